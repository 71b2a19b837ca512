import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { FrameCopy } from './sheet_copy';

// Messages between the page and the worker that plays a recording.

export type ToReplay =
  | { kind: 'open'; file: ArrayBuffer }
  /** `index`: number of the frame, from 0. */
  | { kind: 'seek'; index: number }
  /** Buffers of frames that the page has copied, to be used again. */
  | { kind: 'spare'; buffers: ArrayBuffer[] };

export type FromReplay =
  /** `share`: share of the frames that have been checked, 0..1. */
  | { kind: 'progress'; share: number }
  /** `timesMs`, `ticks`: one number for each frame. */
  | { kind: 'opened'; sheet: Sheet; timesMs: Float64Array; ticks: Float64Array; numTornBytes: number }
  /** `isFirst`: true if the frame does not continue those shown before. */
  | { kind: 'frame'; frame: FrameCopy; index: number; isFirst: boolean }
  | { kind: 'failed'; message: string };
