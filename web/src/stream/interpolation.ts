// Frames at about the rate at which pictures are drawn are shown as they come: a way between them would only delay them.
const kShortestMs = 25;
// After a longer pause a frame is shown at once.
const kLongestMs = 500;
const kSmoothing = 0.3;

/**
 * The way of positions from what is shown to the newest frame. It takes as long as frames are
 * apart. So a sheet whose frames come ten times a second moves evenly, and is shown at most one frame late.
 */
export class Interpolation {
  private from: Float32Array = new Float32Array(0);
  private to: Float32Array = new Float32Array(0);
  private count = 0;
  private startMs = 0;
  private durationMs = 0;
  private arrivedMs = Number.NEGATIVE_INFINITY;
  private intervalMs = 0;
  private isDone = true;

  /**
   * @param shown   what is shown, at least as long as `to`; is `to` at once where there is no way to go
   * @param to      is copied: belongs to the caller again afterwards
   * @param goesOn  false: positions have nothing to do with those before
   */
  take(shown: Float32Array, to: Float32Array, nowMs: number, goesOn: boolean): void {
    const sinceMs = nowMs - this.arrivedMs;
    this.arrivedMs = nowMs;
    if (!goesOn || sinceMs > kLongestMs) {
      // The interval of the frames is measured again.
      this.intervalMs = 0;
      this.jump(shown, to);
      return;
    }
    this.intervalMs = this.intervalMs === 0 ? sinceMs : this.intervalMs + kSmoothing * (sinceMs - this.intervalMs);
    if (this.intervalMs < kShortestMs) {
      this.jump(shown, to);
      return;
    }
    this.advance(shown, nowMs);
    this.count = to.length;
    if (this.from.length < to.length) this.from = new Float32Array(to.length);
    if (this.to.length < to.length) this.to = new Float32Array(to.length);
    this.from.set(shown.subarray(0, to.length));
    this.to.set(to);
    this.startMs = nowMs;
    this.durationMs = this.intervalMs;
    this.isDone = false;
  }

  /** Brings `shown` to `nowMs`; false where nothing has changed since the last call. */
  advance(shown: Float32Array, nowMs: number): boolean {
    if (this.isDone) return false;
    const share = Math.min(1, Math.max(0, (nowMs - this.startMs) / this.durationMs));
    const { from, to, count } = this;
    if (share === 1) shown.set(to.length === count ? to : to.subarray(0, count));
    else for (let i = 0; i < count; ++i) shown[i] = from[i] + share * (to[i] - from[i]);
    this.isDone = share === 1;
    return true;
  }

  private jump(shown: Float32Array, to: Float32Array): void {
    shown.set(to);
    this.isDone = true;
  }
}
