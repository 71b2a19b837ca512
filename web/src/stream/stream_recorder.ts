import { encodeMessage } from './recording_format';

/** Progress of a recording. */
export interface RecordingProgress {
  numFrames: number;
  numBytes: number;
  durationMs: number;
  /** True once the limit is reached; nothing more is added then. */
  isFull: boolean;
}

/**
 * Keeps the messages of a stream, beginning with the first frame of a connection, until they would exceed the limit.
 */
export class StreamRecorder {
  private readonly parts: Uint8Array<ArrayBuffer>[];
  private firstMs: number | undefined;
  private readonly state: RecordingProgress;

  /**
   * @param header      see recording_format.ts
   * @param limitBytes  largest size of the whole file
   */
  constructor(
    header: Uint8Array<ArrayBuffer>,
    private readonly limitBytes: number,
  ) {
    this.parts = [header];
    this.state = { numFrames: 0, numBytes: header.length, durationMs: 0, isFull: false };
  }

  get progress(): RecordingProgress {
    return { ...this.state };
  }

  /**
   * @param bytes    kerf.v1.WatchResponse with a frame
   * @param isFirst  true for the first frame of a connection, which has the full topology
   * @param nowMs    performance.now()
   */
  add(bytes: Uint8Array, isFirst: boolean, nowMs: number): void {
    const { state } = this;
    if (state.isFull || (this.firstMs === undefined && !isFirst)) return;
    this.firstMs ??= nowMs;
    const atMs = nowMs - this.firstMs;
    const record = encodeMessage({ atMs, bytes });
    if (state.numBytes + record.length > this.limitBytes) {
      state.isFull = true;
      return;
    }
    this.parts.push(record);
    state.numFrames += 1;
    state.numBytes += record.length;
    state.durationMs = atMs;
  }

  /** Returns the file in parts, which the caller then owns. */
  finish(): ArrayBuffer[] {
    return this.parts.map((part) => part.buffer);
  }
}
