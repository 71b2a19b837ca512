import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { FromReplay, ToReplay } from './replay_messages';
import { SheetCopy, copiedBuffers } from './sheet_copy';
import type { FrameCopy } from './sheet_copy';
import type { Port } from './watch_messages';

export interface ReplayEvents {
  /** @param share  share of the file that has been checked, 0..1 */
  onProgress(share: number): void;
  onOpened(replay: Replay): void;
  onFrame(copy: SheetCopy, frame: FrameCopy): void;
  /** Called if the file cannot be played; `message` is the reason. */
  onFailed(message: string): void;
}

// Longest time that one step advances, so that a page that was hidden continues from its old position.
const kLongestStepMs = 1000;

/** A recording being played: its position, its speed, and the sheet there. It is decoded in a worker. */
export class Replay {
  /** The sheet and its settings when the recording began. */
  sheet: Sheet | undefined;
  copy: SheetCopy | undefined;
  isPlaying = false;
  /** Playback speed, relative to the recording. */
  speed = 1;
  /** Index of the shown frame; -1 before the first. */
  index = -1;
  /** Bytes of an incomplete frame at the end of the file. */
  numTornBytes = 0;

  private timesMs: Float64Array = new Float64Array(0);
  private ticks: Float64Array = new Float64Array(0);
  private positionMs = 0;
  private lastMs: number | undefined;
  // Index of the frame requested from the worker that has not arrived; undefined: none.
  private asked: number | undefined;

  constructor(
    private readonly port: Port<ToReplay, FromReplay>,
    private readonly events: ReplayEvents,
    file: ArrayBuffer,
  ) {
    port.onmessage = ({ data }) => this.receive(data);
    port.postMessage({ kind: 'open', file }, [file]);
  }

  get numFrames(): number {
    return this.timesMs.length;
  }

  get durationMs(): number {
    return this.timesMs.at(-1) ?? 0;
  }

  /** Position: milliseconds since the first frame, 0..durationMs. */
  get atMs(): number {
    return this.positionMs;
  }

  /** Tick of the frame at the position. */
  get tick(): number {
    return this.ticks[this.frameAt(this.positionMs)] ?? -1;
  }

  /** Starts or stops playing; at the end of the recording, playing starts again from its beginning. */
  togglePlaying(): void {
    this.isPlaying = !this.isPlaying;
    if (this.isPlaying && this.positionMs >= this.durationMs) this.positionMs = 0;
    this.lastMs = undefined;
  }

  seek(atMs: number): void {
    this.positionMs = Math.min(this.durationMs, Math.max(0, atMs));
  }

  /** Moves by this number of frames and pauses. */
  step(frames: number): void {
    this.isPlaying = false;
    const index = Math.min(this.numFrames - 1, Math.max(0, this.frameAt(this.positionMs) + frames));
    this.positionMs = this.timesMs[index] ?? 0;
  }

  /**
   * Advances to `nowMs` and requests the frame there. Only one request runs at a time, so a slow machine skips frames.
   * @returns true if the shown sheet has changed since the last call
   */
  advance(nowMs: number): boolean {
    if (this.isPlaying) {
      this.seek(this.positionMs + this.speed * Math.min(kLongestStepMs, nowMs - (this.lastMs ?? nowMs)));
      this.lastMs = nowMs;
      if (this.positionMs >= this.durationMs) this.isPlaying = false;
    }
    const wanted = this.frameAt(this.positionMs);
    if (wanted >= 0 && wanted !== this.index && this.asked === undefined) {
      this.asked = wanted;
      this.port.postMessage({ kind: 'seek', index: wanted });
    }
    return this.copy?.advance(nowMs) ?? false;
  }

  // Returns the index of the last frame that arrived by `atMs`, by bisection.
  private frameAt(atMs: number): number {
    let [low, high] = [0, this.numFrames];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.timesMs[middle] <= atMs) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  private receive(message: FromReplay): void {
    switch (message.kind) {
      case 'progress':
        return this.events.onProgress(message.share);
      case 'failed':
        return this.events.onFailed(message.message);
      case 'opened':
        this.sheet = message.sheet;
        this.timesMs = message.timesMs;
        this.ticks = message.ticks;
        this.numTornBytes = message.numTornBytes;
        return this.events.onOpened(this);
      case 'frame':
        return this.take(message);
    }
  }

  private take({ frame, index, isFirst }: FromReplay & { kind: 'frame' }): void {
    // Motion is interpolated only between frames that are played in order; all other changes are jumps.
    const goesOn = this.isPlaying && index > this.index;
    this.asked = undefined;
    this.index = index;
    if (isFirst || !this.copy) this.copy = new SheetCopy();
    this.copy.take(frame, performance.now(), goesOn);
    this.events.onFrame(this.copy, frame);
    const buffers = copiedBuffers(frame);
    this.port.postMessage({ kind: 'spare', buffers }, buffers);
  }
}
