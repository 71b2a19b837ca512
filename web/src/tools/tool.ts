import type { Ray, Vector2 } from 'three';
import type { Reporter } from '../notifier';
import type { Stage } from '../scene/stage';
import type { GestureStream, OpenSheet, ShownState } from '../sheet/open_sheet';

export type ToolId = 'view' | 'cut' | 'grab' | 'pin' | 'measure' | 'pick';

export interface Pointer {
  /** Place on the canvas, CSS pixels. */
  px: Vector2;
  ray: Ray;
}

/**
 * A tool handles gestures while it is chosen; a gesture that it does not take moves the view. Its keys are in
 * ui/shortcuts.ts.
 */
export interface Tool {
  readonly id: ToolId;
  /** CSS cursor over the canvas. */
  readonly cursor: string;
  enter(): void;
  leave(): void;
  /** Called when the pointer goes down; true takes the gesture, so that drag() and release() follow. */
  press(pointer: Pointer): boolean;
  drag(pointer: Pointer): void;
  release(): void;
  /** Called at a second finger: undoes the gesture that press() took, which now moves the view. */
  abandon(): void;
  /** Called when the pointer went down and up in one place and press() did not take the gesture. */
  tap(pointer: Pointer): void;
  /** Called before each drawing, to follow the sheet, which may have moved. */
  update(): void;
}

/** The parts of the viewer that tools use. */
export interface Viewer {
  readonly stage: Stage;
  /** Element that covers the canvas exactly and holds handles. */
  readonly overlay: HTMLElement;
  readonly shown: ShownState;
  readonly live: OpenSheet & GestureStream;
  readonly notices: Reporter;
}
