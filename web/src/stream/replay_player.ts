import { fromBinary } from '@bufbuild/protobuf';
import { WatchResponseSchema } from '../gen/kerf/v1/stream_pb';
import type { Frame } from '../gen/kerf/v1/stream_pb';
import { SheetMirror } from './mirror';
import { RecordingError } from './recording_format';
import type { Recording } from './recording_format';

// Largest number of frames decoded to seek; at 10,000 vertices that takes a tenth of a second.
const kFramesBetweenCopies = 64;

/** The sheet at a frame, and data about the frame. */
export interface ReplayedFrame {
  mirror: SheetMirror;
  numBytes: number;
  isKeyframe: boolean;
}

/** Decodes the frames of a recording in any order, each from the nearest earlier copy of the sheet. */
export class ReplayPlayer {
  /** Tick of each frame; NaN until the frame is first decoded. */
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
   * @param index  0..numFrames - 1; seek() must have been called before for every smaller index
   * @throws RecordingError
   */
  seek(index: number): ReplayedFrame {
    const from = Math.floor(index / kFramesBetweenCopies);
    // Decodes forwards from the present frame, unless a copy is nearer.
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
    // The first frame of a connection does not depend on earlier frames.
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
