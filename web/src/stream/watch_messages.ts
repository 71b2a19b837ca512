import type { Rejection } from '../gen/kerf/v1/stream_pb';
import type { ConnectionState } from './connection';
import type { FrameCopy } from './sheet_copy';
import type { RecordingProgress } from './stream_recorder';
import type { AudienceNews, Pace, ProbeRequest, WatchRequestKind } from './watch';

// Messages between the page and the worker that holds its connection. `id` numbers the page's streams; messages about
// an earlier stream are ignored.

/** Options with which a stream starts. */
export interface StreamStart {
  strains: boolean;
  /** Quantities that come with each frame, see FrameCopy.probeValues. */
  probes?: ProbeRequest[];
  /** True to continue from the triangles of the previous stream, which was of the same sheet. */
  goesOn: boolean;
  pace: Pace;
}

export type ToWorker =
  | ({ kind: 'start'; id: number; url: string; name: string } & StreamStart)
  /** `spare`: buffers of frames that the page has copied, to be used again. */
  | { kind: 'acknowledge'; id: number; spare: ArrayBuffer[] }
  | { kind: 'send'; id: number; request: WatchRequestKind }
  | { kind: 'pace'; id: number; pace: Pace }
  | { kind: 'retry'; id: number }
  | { kind: 'close'; id: number }
  /** Records from the next connection on, which begins with the whole topology; see StreamRecorder. */
  | { kind: 'record'; header: Uint8Array<ArrayBuffer>; limitBytes: number }
  /** Answered by `recorded`. */
  | { kind: 'stopRecording' };

export type FromWorker =
  | { kind: 'state'; id: number; state: ConnectionState; detail: string }
  /** `isFirst`: true for the first frame of a connection. */
  | { kind: 'frame'; id: number; frame: FrameCopy; isFirst: boolean }
  | { kind: 'rejection'; id: number; rejection: Rejection }
  | { kind: 'news'; id: number; news: AudienceNews }
  | { kind: 'recording'; progress: RecordingProgress }
  /** `parts`: content of the file. */
  | { kind: 'recorded'; progress: RecordingProgress; parts: ArrayBuffer[] };

/** The part of the interfaces of Worker and of a worker's scope that is used here. */
export interface Port<Out, In> {
  postMessage(message: Out, transfer?: Transferable[]): void;
  onmessage: ((event: MessageEvent<In>) => void) | null;
}
