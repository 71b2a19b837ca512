import type { FrameStats } from '../gen/kerf/v1/stream_pb';
import type { NoticeKind } from '../notifier';
import { isBehind } from './run_text';

type SeenStats = Pick<FrameStats, 'realTimeFactor' | 'speed' | 'paused' | 'sleeping'>;

// Time for which a sheet must be behind: the real-time factor covers about a second, and other work of the machine
// disturbs it.
const kBehindMs = 3000;

/**
 * Says why a sheet falls behind real time and what would help. It does so once, until the sheet has kept pace again.
 */
export class SlowSheet {
  private name = '';
  private changedMs = 0; // time at which the sheet began to be behind, or to keep pace
  private isSlow = false;
  private isTold = false;

  /**
   * @param advice  fetches the server's advice about the sheet; empty if its ticks are short enough and only the
   *   machine is busy
   */
  constructor(
    private readonly notify: (kind: NoticeKind, text: string) => void,
    private readonly advice: () => Promise<string>,
  ) {}

  /** Takes a live frame of sheets/{sheet} at `nowMs` (performance.now()). */
  async saw(name: string, stats: SeenStats, nowMs: number): Promise<void> {
    const isSlow = isBehind(stats);
    if (name !== this.name || isSlow !== this.isSlow) {
      if (name !== this.name) this.isTold = false;
      this.name = name;
      this.isSlow = isSlow;
      this.changedMs = nowMs;
      return;
    }
    if (nowMs - this.changedMs < kBehindMs || isSlow === this.isTold) return;
    this.isTold = isSlow;
    if (!isSlow) return;
    const text = await this.advice();
    if (text && name === this.name) this.notify('warning', text);
  }
}
