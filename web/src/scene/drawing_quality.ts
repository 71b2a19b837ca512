/** A level of detail for drawing pictures. */
export interface Quality {
  /** Pixels in each direction, as a share of those of full resolution. */
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
// Pictures per second: below kLeastRateHz drawing becomes coarser; above kRoomRateHz a finer level may be tried.
const kLeastRateHz = 20;
const kRoomRateHz = 45;
// A rate is measured over at least this time and this number of pictures. The slowest picture does not count.
const kWindowMs = 1000;
const kFewestPictures = 3;
// A picture that has not changed for this long counts as still.
const kStillMs = 500;
// A good rate must last this long before a finer level is tried. Each try that was too slow doubles the time.
const kFirstPatienceMs = 3000;
const kLongestPatienceMs = 96_000;

/**
 * Chooses how finely pictures are drawn: step by step more coarsely while their rate is too low, and finer again when
 * there is room. A still picture is drawn at the finest level. The caller passes all times, in milliseconds.
 */
export class DrawingQuality {
  /** True if the rate is too low even at the coarsest level. */
  isTooSlow = false;

  private level = 0;
  private isTrial = false;
  private patienceMs = kFirstPatienceMs;
  private goodMs = 0;
  private numPictures = 0;
  private spentMs = 0;
  private longestMs = 0;
  private movedMs = Number.NEGATIVE_INFINITY;

  /** Call it when a picture is drawn that differs from the one before. */
  moved(nowMs: number): void {
    this.movedMs = nowMs;
  }

  /** @param isMoving  true if the sheet moves by itself */
  at(nowMs: number, isMoving: boolean): Quality {
    return kLevels[isMoving || nowMs - this.movedMs < kStillMs ? this.level : 0];
  }

  /** Records the time that a picture took. It is one of several in a row, drawn at the level for moving pictures. */
  took(pictureMs: number): void {
    this.numPictures += 1;
    this.spentMs += pictureMs;
    this.longestMs = Math.max(this.longestMs, pictureMs);
    if (this.spentMs < kWindowMs || this.numPictures < kFewestPictures) return;
    // Leaves out the slowest picture, since a single hitch, such as compiling a shader, does not recur.
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
