/**
 * Measures the age of frames without synchronised clocks. The smallest difference seen between arrival here and
 * publication on the server counts as the clocks' offset plus the shortest transit. Ages are thus relative to the
 * fastest frame of this stream.
 */
export class FrameClock {
  private offsetMs = Number.POSITIVE_INFINITY;
  private publishedMs = 0;

  /**
   * @param publishedUnixUs  kerf.v1.FrameStats.published_unix_us
   * @param localMs          this machine's Unix time on arrival, milliseconds
   */
  arrived(publishedUnixUs: bigint, localMs: number): void {
    this.publishedMs = Number(publishedUnixUs) / 1000;
    this.offsetMs = Math.min(this.offsetMs, localMs - this.publishedMs);
  }

  /** Returns the age at `localMs` of the last frame's state, ms, >= 0; undefined before the first frame. */
  ageMs(localMs: number): number | undefined {
    return Number.isFinite(this.offsetMs) ? Math.max(0, localMs - this.publishedMs - this.offsetMs) : undefined;
  }
}

/** Unix time in milliseconds with the resolution of performance.now(). */
export function unixTimeMs(): number {
  return performance.timeOrigin + performance.now();
}
