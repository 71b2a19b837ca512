import { encodeMessage } from './recording_format';

/** Progress of a recording. */
export interface RecordingProgress {
  numFrames: number;
  numBytes: number;
  durationMs: number;
  /** The limit is reached: nothing is added any more. */
  isFull: boolean;
}

/** Keeps the messages of a stream from the first frame of a connection on, until they would take more than the limit. */
export class StreamRecorder {
  private readonly parts: Uint8Array<ArrayBuffer>[];
  private firstMs: number | undefined;
  private readonly state: RecordingProgress;

  /**
   * @param header      see recording_format.ts
   * @param limitBytes  of the whole file
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
   * @param isFirst  of a connection: with the full topology
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

  /** The file, in parts; whoever takes them owns them. */
  finish(): ArrayBuffer[] {
    return this.parts.map((part) => part.buffer);
  }
}
