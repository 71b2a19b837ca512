import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { Surface } from '../geometry/surface';
import type { RemoteWatch } from '../stream/remote_watch';

/** The live sheet on which calls to the server act. */
export interface OpenSheet {
  /**
   * sheets/{sheet}; empty if no sheet is open. It stays while a recording is shown, because closing the recording
   * returns to the sheet.
   */
  readonly sheetName: string;
  /** Fetches the settings after a change whose answer did not contain them. */
  refresh(): Promise<void>;
}

/** The stream of the live sheet, for gestures that send commands while they last. */
export interface GestureStream {
  /** Undefined without a live sheet, and while a recording is shown. */
  readonly watch: Pick<RemoteWatch, 'state' | 'send'> | undefined;
}

/** The sheet that is shown: live or from a recording. */
export interface ShownState {
  /** Undefined before the first frame. */
  readonly surface: Surface | undefined;
  /** Settings, as the server last gave them or as they were recorded. */
  readonly sheet: Sheet | undefined;
}
