// Frames closer together than this are shown as they come; interpolating between them would only delay them.
const kShortestMs = 25;
// A frame after a longer pause is shown at once.
const kLongestMs = 500;
const kSmoothing = 0.3;

/**
 * Moves positions from those shown to those of the newest frame, in the time between two frames. A sheet with ten
 * frames per second thus moves evenly, and is shown at most one frame late.
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
   * @param shown   the shown positions, at least as long as `to`; set to `to` at once if there is nothing to
   *   interpolate
   * @param to      positions of the newest frame; copied, so the caller may reuse the array
   * @param goesOn  false: the positions do not continue those before
   */
  take(shown: Float32Array, to: Float32Array, nowMs: number, goesOn: boolean): void {
    const sinceMs = nowMs - this.arrivedMs;
    this.arrivedMs = nowMs;
    if (!goesOn || sinceMs > kLongestMs) {
      // The interval between frames is measured again.
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

  /** Moves `shown` to its positions at `nowMs`; false if nothing has changed since the last call. */
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
