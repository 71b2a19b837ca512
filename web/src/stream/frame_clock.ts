/**
 * Age of frames without synchronised clocks. The smallest difference seen between arrival here and publication there
 * counts as the clocks' offset plus the shortest way. So ages are relative to the fastest frame of this stream.
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

  /** Age at `localMs` of the state that the last frame shows, ms, >= 0; undefined before the first. */
  ageMs(localMs: number): number | undefined {
    return Number.isFinite(this.offsetMs) ? Math.max(0, localMs - this.publishedMs - this.offsetMs) : undefined;
  }
}

/** Unix time in milliseconds with the resolution of performance.now(). */
export function unixTimeMs(): number {
  return performance.timeOrigin + performance.now();
}
