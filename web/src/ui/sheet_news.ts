import { Sheet_RunState } from '../gen/kerf/v1/sheets_pb';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { FrameStats } from '../gen/kerf/v1/stream_pb';
import type { NoticeKind } from '../notifier';
import type { SheetCopy } from '../stream/sheet_copy';

type SeenStats = Pick<FrameStats, 'resets' | 'resetsUndone'>;

type SeenCopy = Pick<SheetCopy, 'epoch' | 'hasGoneBack'>;

interface Seen {
  name: string;
  epoch: string;
  resets: number;
  resetsUndone: number;
}

/** Reports changes of the sheet as a whole, made by any viewer or by a restart of the server. */
export class SheetNews {
  private seen: Seen | undefined;

  constructor(private readonly notify: (kind: NoticeKind, text: string) => void) {}

  /**
   * Takes a live frame.
   * @param name   sheets/{sheet}
   * @param copy   the sheet as the frame left it
   */
  saw(name: string, { epoch, hasGoneBack }: SeenCopy, { resets, resetsUndone }: SeenStats): void {
    const before = this.seen;
    this.seen = { name, epoch, resets, resetsUndone };
    if (before?.name !== name) return;
    if (before.epoch !== epoch && hasGoneBack) {
      this.notify('info', 'The sheet went back to a saved state');
    } else if (before.epoch !== epoch) {
      this.notify('warning', 'The server was restarted, or the sheet created again: it is back at its beginning');
    } else if (resets > before.resets) {
      this.notify('info', 'The sheet was reset; Undo brings back what was there');
    } else if (resetsUndone > before.resetsUndone) {
      this.notify('info', 'The reset was undone');
    }
  }

  /**
   * Takes the settings of the shown sheet.
   * @param before  the previous settings; undefined for the first ones of a sheet
   */
  sawSettings({ runState }: Pick<Sheet, 'runState'>, before: Pick<Sheet, 'runState'> | undefined): void {
    if (runState === Sheet_RunState.FAILED && before?.runState !== Sheet_RunState.FAILED) {
      this.notify('error', 'The sheet is frozen at its last good tick. Reset it to continue.');
    }
  }
}
