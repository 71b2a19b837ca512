import { fromBinary } from '@bufbuild/protobuf';
import { WatchResponseSchema } from '../gen/kerf/v1/stream_pb';
import type { Frame } from '../gen/kerf/v1/stream_pb';
import { SheetMirror } from './mirror';
import { RecordingError } from './recording_format';
import type { Recording } from './recording_format';

// At most so many frames are decoded to seek: a tenth of a second at 10,000 vertices.
const kFramesBetweenCopies = 64;

/** Data of a frame besides the sheet. */
export interface ReplayedFrame {
  mirror: SheetMirror;
  numBytes: number;
  isKeyframe: boolean;
}

/** The frames of a recording in any order, each decoded from the nearest copy of the sheet before it. */
export class ReplayPlayer {
  /** Value of each frame; NaN until it is first decoded. */
  readonly ticks: Float64Array;
  private readonly copies: SheetMirror[] = [];
  private mirror = new SheetMirror();
  private at = -1;

  constructor(private readonly recording: Recording) {
    this.ticks = new Float64Array(recording.messages.length).fill(Number.NaN);
  }

  get numFrames(): number {
    return this.recording.messages.length;
  }

  /**
   * @param index  0..numFrames - 1; all before it must have been sought once
   * @throws RecordingError
   */
  seek(index: number): ReplayedFrame {
    const from = Math.floor(index / kFramesBetweenCopies);
    // Forwards from where it is, unless there is a copy on the way.
    if (index < this.at || from * kFramesBetweenCopies > this.at) {
      const copy = this.copies[from];
      if (copy) {
        this.mirror = copy.copy();
        this.at = from * kFramesBetweenCopies;
      }
    }
    while (this.at < index) this.apply(this.at + 1);
    const { bytes } = this.recording.messages[index];
    return { mirror: this.mirror, numBytes: bytes.length, isKeyframe: this.frame(index).baseTick === -1n };
  }

  private frame(index: number): Frame {
    try {
      const { kind } = fromBinary(WatchResponseSchema, this.recording.messages[index].bytes);
      if (kind.case === 'frame') return kind.value;
    } catch (error) {
      throw new RecordingError(`frame ${index + 1} cannot be read: ${(error as Error).message}`);
    }
    throw new RecordingError(`message ${index + 1} is not a frame`);
  }

  private apply(index: number): void {
    const frame = this.frame(index);
    // The first of a connection. It owes nothing to what was before.
    if (frame.sequence === 1n) this.mirror = new SheetMirror();
    try {
      this.mirror.apply(frame);
    } catch (error) {
      throw new RecordingError(`frame ${index + 1}: ${(error as Error).message}`);
    }
    this.at = index;
    this.ticks[index] = this.mirror.tick;
    if (index % kFramesBetweenCopies === 0) this.copies[index / kFramesBetweenCopies] ??= this.mirror.copy();
  }
}
