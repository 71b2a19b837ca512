import type { Ray, Vector2 } from 'three';
import type { Reporter } from '../notifier';
import type { Stage } from '../scene/stage';
import type { GestureStream, OpenSheet, ShownState } from '../sheet/open_sheet';

export type ToolId = 'view' | 'cut' | 'grab' | 'pin';

export interface Pointer {
  /** On the canvas, CSS pixels. */
  px: Vector2;
  ray: Ray;
}

/** Gives gestures a meaning while it is chosen; one that it does not take moves the view. Its keys are in ui/shortcuts.ts. */
export interface Tool {
  readonly id: ToolId;
  /** CSS cursor over the canvas. */
  readonly cursor: string;
  enter(): void;
  leave(): void;
  /** The pointer went down; true takes the gesture, which drag() and release() then follow. */
  press(pointer: Pointer): boolean;
  drag(pointer: Pointer): void;
  release(): void;
  /** A second finger came: the gesture that press() took is the view's now, and its beginning is undone. */
  abandon(): void;
  /** The pointer went down and up in one place, and press() did not take it. */
  tap(pointer: Pointer): void;
  /** Follows the sheet, which may have moved, before each drawing. */
  update(): void;
}

/** The parts of the viewer that tools use. */
export interface Viewer {
  readonly stage: Stage;
  /** Covers the canvas exactly, and takes handles. */
  readonly overlay: HTMLElement;
  readonly shown: ShownState;
  readonly live: OpenSheet & GestureStream;
  readonly notices: Reporter;
}
