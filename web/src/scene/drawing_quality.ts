/** The fineness with which a picture is drawn. */
export interface Quality {
  /** Its pixels against those of full resolution, in each direction. */
  scale: number;
  hasShadows: boolean;
}

// The levels from the finest to the coarsest.
const kLevels: readonly Quality[] = [
  { scale: 1, hasShadows: true },
  { scale: 0.75, hasShadows: true },
  { scale: 0.5, hasShadows: true },
  { scale: 0.5, hasShadows: false },
];
// Pictures a second: below the first it is drawn more coarsely, above the second there is room for more.
const kLeastRateHz = 20;
const kRoomRateHz = 45;
// A rate is measured over this time at least, and over so many pictures, of which the longest does not count.
const kWindowMs = 1000;
const kFewestPictures = 3;
// A picture that has not changed for so long is still.
const kStillMs = 500;
// A good rate lasts so long before a finer level is tried; each try that was too slow doubles it.
const kFirstPatienceMs = 3000;
const kLongestPatienceMs = 96_000;

/**
 * Chooses how finely pictures are drawn: more coarsely step by step while they come too seldom, finer again when there is
 * room. A still picture is as fine as can be. Times are given to it, in milliseconds.
 */
export class DrawingQuality {
  /** Even the coarsest pictures come too seldom. */
  isTooSlow = false;

  private level = 0;
  private isTrial = false;
  private patienceMs = kFirstPatienceMs;
  private goodMs = 0;
  private numPictures = 0;
  private spentMs = 0;
  private longestMs = 0;
  private movedMs = Number.NEGATIVE_INFINITY;

  /** A picture that differs from the one before is drawn. */
  moved(nowMs: number): void {
    this.movedMs = nowMs;
  }

  /** @param isMoving  the sheet moves by itself */
  at(nowMs: number, isMoving: boolean): Quality {
    return kLevels[isMoving || nowMs - this.movedMs < kStillMs ? this.level : 0];
  }

  /** One of several pictures in a row, at the level that is for moving ones, took this long. */
  took(pictureMs: number): void {
    this.numPictures += 1;
    this.spentMs += pictureMs;
    this.longestMs = Math.max(this.longestMs, pictureMs);
    if (this.spentMs < kWindowMs || this.numPictures < kFewestPictures) return;
    // A single hitch, as when a shader is compiled, says nothing of the others.
    const rateHz = (1000 * (this.numPictures - 1)) / (this.spentMs - this.longestMs);
    this.judge(rateHz, this.spentMs);
    this.numPictures = this.spentMs = this.longestMs = 0;
  }

  private judge(rateHz: number, durationMs: number): void {
    this.isTooSlow = rateHz < kLeastRateHz && this.level === kLevels.length - 1;
    if (rateHz < kLeastRateHz) {
      if (this.isTrial) this.patienceMs = Math.min(2 * this.patienceMs, kLongestPatienceMs);
      this.setLevel(Math.min(this.level + 1, kLevels.length - 1), false);
      return;
    }
    if (this.isTrial) {
      this.isTrial = false;
      this.patienceMs = kFirstPatienceMs;
    }
    this.goodMs = rateHz < kRoomRateHz ? 0 : this.goodMs + durationMs;
    if (this.goodMs >= this.patienceMs && this.level > 0) this.setLevel(this.level - 1, true);
  }

  private setLevel(level: number, isTrial: boolean): void {
    this.level = level;
    this.isTrial = isTrial;
    this.goodMs = 0;
  }
}
