import { SampleWindow } from './sample_window';

/** Cost of one message of a stream, measured where it arrived. */
export interface Delivery {
  /** Size of the whole message. */
  numBytes: number;
  /** Can be read without those before it. */
  isKeyframe: boolean;
  /** Frames that had come and were not acknowledged, with this one. */
  numUnacknowledged: number;
  decodeMs: number;
}

/** The figures of kerf.v1.FrameStats that are measured on the way. */
export interface TickFigures {
  /** Ticks that were not sent before this one. */
  skipped: number;
  tickCpuUs: number;
}

const kSpanMs = 5000;
// Holds 5 s at 1000 Hz, the highest rate that a stream can have, the newest four.
const kCapacity = 4096;

/** The last seconds of a stream. Holds numbers only of what it is given, so that it costs nothing while it is not read. */
export class StreamMeter {
  readonly spanMs = kSpanMs;
  readonly drawn = new SampleWindow(kSpanMs, kCapacity);
  /** ms, of frames as they were drawn */
  readonly ages = new SampleWindow(kSpanMs, kCapacity);
  readonly bytes = new SampleWindow(kSpanMs, kCapacity);
  readonly keyframes = new SampleWindow(kSpanMs, kCapacity);
  readonly skipped = new SampleWindow(kSpanMs, kCapacity);
  /** us */
  readonly tickTimes = new SampleWindow(kSpanMs, kCapacity);
  readonly unacknowledged = new SampleWindow(kSpanMs, kCapacity);
  /** ms */
  readonly decodeTimes = new SampleWindow(kSpanMs, kCapacity);

  private get windows(): SampleWindow[] {
    const { drawn, ages, bytes, keyframes, skipped, tickTimes, unacknowledged, decodeTimes } = this;
    return [drawn, ages, bytes, keyframes, skipped, tickTimes, unacknowledged, decodeTimes];
  }

  arrived(nowMs: number, delivery: Delivery, figures: TickFigures | undefined): void {
    this.bytes.add(nowMs, delivery.numBytes);
    this.keyframes.add(nowMs, delivery.isKeyframe ? 1 : 0);
    this.unacknowledged.add(nowMs, delivery.numUnacknowledged);
    this.decodeTimes.add(nowMs, delivery.decodeMs);
    if (!figures) return;
    this.skipped.add(nowMs, figures.skipped);
    this.tickTimes.add(nowMs, figures.tickCpuUs);
  }

  /** @param ageMs  of what was drawn; undefined where it was drawn before or its age is not known */
  wasDrawn(nowMs: number, ageMs: number | undefined): void {
    this.drawn.add(nowMs, 1);
    if (ageMs !== undefined) this.ages.add(nowMs, ageMs);
  }

  forget(nowMs: number): void {
    for (const window of this.windows) window.forget(nowMs);
  }

  clear(): void {
    for (const window of this.windows) window.clear();
  }
}
