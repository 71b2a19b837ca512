import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { FrameCopy } from './sheet_copy';

// Messages between the page and the worker that plays a recording.

export type ToReplay =
  | { kind: 'open'; file: ArrayBuffer }
  /** `index`: of the frame, from 0. */
  | { kind: 'seek'; index: number }
  /** Arrays of frames that the page has copied, to be used again. */
  | { kind: 'spare'; buffers: ArrayBuffer[] };

export type FromReplay =
  /** `share`: of the frames that were checked, 0..1. */
  | { kind: 'progress'; share: number }
  /** `timesMs`, `ticks`: of each frame. */
  | { kind: 'opened'; sheet: Sheet; timesMs: Float64Array; ticks: Float64Array; numTornBytes: number }
  /** `isFirst`: it has nothing to do with those that were shown before. */
  | { kind: 'frame'; frame: FrameCopy; index: number; isFirst: boolean }
  | { kind: 'failed'; message: string };
