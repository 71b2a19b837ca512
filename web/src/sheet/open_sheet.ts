import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { Surface } from '../geometry/surface';
import type { RemoteWatch } from '../stream/remote_watch';

/** The live sheet that calls to the server are about. */
export interface OpenSheet {
  /** sheets/{sheet}; empty without one. It stays while a recording is shown: closing that leads back to it. */
  readonly sheetName: string;
  /** Asks for the settings after a change that was not answered by them. */
  refresh(): Promise<void>;
}

/** The stream of the live sheet, for gestures that act on it while they last. */
export interface GestureStream {
  /** Undefined without a live sheet, and while a recording is shown. */
  readonly watch: Pick<RemoteWatch, 'state' | 'send'> | undefined;
}

/** The sheet that is seen, of the live stream or of a recording. */
export interface ShownState {
  /** Undefined before the first frame. */
  readonly surface: Surface | undefined;
  /** Settings, as the server last gave them or as they were recorded. */
  readonly sheet: Sheet | undefined;
}
