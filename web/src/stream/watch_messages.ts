import type { Rejection } from '../gen/kerf/v1/stream_pb';
import type { FrameCopy } from './sheet_copy';
import type { ConnectionState, WatchRequestKind } from './watch';

// What the page and the worker that holds its connection say to each other. `id` numbers the page's streams: what concerns an
// earlier one is passed over.

export type ToWorker =
  /** `goesOn`: from the triangles of the stream before, of the same sheet. */
  | { kind: 'start'; id: number; url: string; name: string; strains: boolean; goesOn: boolean; isPaused: boolean }
  | { kind: 'acknowledge'; id: number }
  | { kind: 'send'; id: number; request: WatchRequestKind }
  | { kind: 'pause'; id: number; isPaused: boolean }
  | { kind: 'retry'; id: number }
  | { kind: 'close'; id: number };

export type FromWorker =
  | { kind: 'state'; id: number; state: ConnectionState; detail: string }
  /** `isFirst`: of a connection. */
  | { kind: 'frame'; id: number; frame: FrameCopy; isFirst: boolean }
  | { kind: 'rejection'; id: number; rejection: Rejection };

/** The part of Worker and of a worker's own scope that is used. */
export interface Port<Out, In> {
  postMessage(message: Out, transfer?: Transferable[]): void;
  onmessage: ((event: MessageEvent<In>) => void) | null;
}
