import { SampleWindow } from './sample_window';

/** Cost of one message of a stream, measured by the receiver. */
export interface Delivery {
  /** Size of the whole message. */
  numBytes: number;
  /** True if the message can be decoded without those before it. */
  isKeyframe: boolean;
  /** Number of frames received and not acknowledged, including this one. */
  numUnacknowledged: number;
  decodeMs: number;
}

/** The figures of kerf.v1.FrameStats that the server measures. */
export interface TickFigures {
  /** Ticks since the frame before that were not sent. */
  skipped: number;
  tickCpuUs: number;
}

const kSpanMs = 5000;
// At 1000 Hz, the highest rate of a stream, this holds the newest four of the 5 s.
const kCapacity = 4096;

/** Figures of the last seconds of a stream. It only stores numbers and computes nothing until it is read. */
export class StreamMeter {
  readonly spanMs = kSpanMs;
  readonly drawn = new SampleWindow(kSpanMs, kCapacity);
  /** Ages of frames when they were drawn, ms */
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

  /** @param ageMs  age of the frame drawn; undefined if it was drawn before or its age is not known */
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
