import type { Ray, Vector2 } from 'three';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { Surface } from '../geometry/surface';
import type { Stage } from '../scene/stage';
import type { RemoteWatch } from '../stream/remote_watch';

export type ToolId = 'view' | 'cut' | 'grab' | 'pin';

export interface Pointer {
  /** On the canvas, CSS pixels. */
  px: Vector2;
  ray: Ray;
}

/** What a press or a drag means while the tool is chosen; its keys are in ui/shortcuts.ts. What a tool does not take moves the view. */
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
  /** A second finger came: the gesture that press() took is the view's, and what it began is undone. */
  abandon(): void;
  /** The pointer went down and up in one place, and press() did not take it. */
  tap(pointer: Pointer): void;
  /** Before each drawing: the sheet may have moved. */
  update(): void;
}

export type NoticeKind = 'info' | 'success' | 'warning' | 'error';

/** What tools may use of the viewer. */
export interface Viewer {
  readonly stage: Stage;
  /** Covers the canvas exactly; takes handles. */
  readonly overlay: HTMLElement;
  /** sheets/{sheet} */
  readonly sheetName: string;
  readonly surface: Surface | undefined;
  readonly watch: RemoteWatch | undefined;
  /** As last told by the server. */
  readonly sheet: Sheet | undefined;
  /** @param details  shown on request */
  notify(kind: NoticeKind, text: string, details?: readonly string[]): void;
  /**
   * Runs a call; its failure becomes a notice. Undefined if it failed.
   * @param what  begins the notice: "Nothing was cut: "
   */
  attempt<T>(call: () => Promise<T>, what?: string): Promise<T | undefined>;
  refreshSheet(): Promise<void>;
}
