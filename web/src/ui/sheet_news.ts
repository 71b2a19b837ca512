import type { FrameStats } from '../gen/kerf/v1/stream_pb';
import type { NoticeKind } from '../tools/tool';

type SeenStats = Pick<FrameStats, 'resets' | 'resetsUndone'>;

interface Seen {
  name: string;
  epoch: string;
  resets: number;
  resetsUndone: number;
}

/** Says what somebody, or a restart of the server, did to the sheet as a whole, to everybody who watches it. */
export class SheetNews {
  private seen: Seen | undefined;

  constructor(private readonly notify: (kind: NoticeKind, text: string) => void) {}

  /**
   * Takes a live frame.
   * @param name   sheets/{sheet}
   * @param epoch  kerf.v1.Frame.epoch of its stream
   */
  saw(name: string, epoch: string, { resets, resetsUndone }: SeenStats): void {
    const before = this.seen;
    this.seen = { name, epoch, resets, resetsUndone };
    if (before?.name !== name) return;
    if (before.epoch !== epoch) {
      this.notify('warning', 'The server was restarted, or the sheet made again: it is back at its beginning');
    } else if (resets > before.resets) {
      this.notify('info', 'The sheet was reset; Undo brings back what was there');
    } else if (resetsUndone > before.resetsUndone) {
      this.notify('info', 'The reset was undone');
    }
  }
}
