import type { FrameStats } from '../gen/kerf/v1/stream_pb';
import { Interpolation } from './interpolation';
import type { Delivery } from './stream_meter';

/**
 * A sheet as the parts of the viewer read it. Arrays may have spare room at the end; only the stated lengths are valid.
 */
export interface SheetArrays {
  /** Topology versions of different epochs cannot be compared. */
  readonly epoch: string;
  /** Tick of the last frame; -1 before the first. */
  readonly tick: number;
  /** -1 before the first frame */
  readonly topologyVersion: number;
  /** V */
  readonly numVertices: number;
  /** S, empty slots included */
  readonly numSlots: number;
  /** Number of pieces of the whole sheet. */
  readonly numPieces: number;
  /** 3 V: x, y, z interleaved, metres, world */
  readonly positions: Float32Array;
  /** 2 V: x, y interleaved, metres */
  readonly materialPositions: Float32Array;
  /** 3 S vertex ids, counter-clockwise in material coordinates; (-1, -1, -1) for an empty slot */
  readonly triangles: Int32Array;
  /** S, -1 for an empty slot */
  readonly pieces: Int32Array;
  /** V principal strains of the largest magnitude, -; undefined if the last frame had none */
  readonly strains: Float32Array | undefined;
  readonly stats: FrameStats | undefined;
}

/** Numbers that describe a sheet. */
export type SheetFigures = Pick<SheetArrays, 'tick' | 'numVertices' | 'numPieces' | 'stats'>;

/** Triangles, pieces and material positions of one topology version, in arrays of exactly their length. */
export interface TopologyCopy {
  triangles: Int32Array;
  pieces: Int32Array;
  materialPositions: Float32Array;
}

/** Returns the buffers of the frame's arrays that SheetCopy.take() copies and does not keep. */
export function copiedBuffers({ positions, strains }: FrameCopy): ArrayBuffer[] {
  return [positions, strains].filter((array) => array !== undefined).map((array) => array.buffer as ArrayBuffer);
}

/** A decoded frame, as the worker sends it to the page. */
export interface FrameCopy {
  /** kerf.v1.Frame.epoch of the frame with which the sheet began, in this stream. */
  epoch: string;
  tick: number;
  topologyVersion: number;
  numSlots: number;
  numPieces: number;
  /** 3 V, without spare room */
  positions: Float32Array;
  strains: Float32Array | undefined;
  /** Values of the stream's probes at `tick`, one for each column. */
  probeValues: readonly number[];
  /** Names of those values; present in a connection's first frame. */
  probeColumns: readonly string[] | undefined;
  stats: FrameStats | undefined;
  /** Arrival, this machine's Unix time, milliseconds. */
  arrivedMs: number;
  /** Present if the topology has changed since the previous frame, and in a connection's first frame. */
  topology: TopologyCopy | undefined;
  delivery: Delivery;
}

/**
 * The page's copy of a sheet. `positions` are those shown: they move from frame to frame if frames come more slowly
 * than pictures are drawn. Everything else is the newest frame's.
 */
export class SheetCopy implements SheetArrays {
  epoch = '';
  tick = -1;
  topologyVersion = -1;
  numVertices = 0;
  numSlots = 0;
  numPieces = 0;
  positions = new Float32Array(0);
  materialPositions = new Float32Array(0);
  triangles = new Int32Array(0);
  pieces = new Int32Array(0);
  strains: Float32Array | undefined;
  stats: FrameStats | undefined;
  /** Values of the stream's probes at `tick`, one for each of `probeColumns`; NaN where there is nothing to measure. */
  probeValues: readonly number[] = [];
  /** Names of the values, such as "tip.x"; empty without probes. */
  probeColumns: readonly string[] = [];

  /** @param hasGoneBack  true for a copy that began when the watched sheet went back to a saved state */
  constructor(readonly hasGoneBack = false) {}

  /** Returns an empty copy for the frames after a return to a saved state, in the stream of `before`. */
  static goneBack(before: SheetCopy): SheetCopy {
    const copy = new SheetCopy(true);
    copy.probeColumns = before.probeColumns;
    return copy;
  }

  private strainRoom = new Float32Array(0);
  private readonly interpolation = new Interpolation();

  /**
   * Copies positions and strains, keeps the arrays of a topology.
   * @param nowMs   performance.now()
   * @param isNext  true if the frame continues the frames taken before
   */
  take(frame: FrameCopy, nowMs: number, isNext = true): void {
    const count = frame.positions.length;
    // After a change of topology a vertex number may mean another vertex, so nothing is interpolated.
    const goesOn = isNext && frame.topology === undefined && count === 3 * this.numVertices && !frame.stats?.paused;
    if (this.positions.length < count) this.positions = new Float32Array(Math.max(count, 2 * this.positions.length));
    this.interpolation.take(this.positions, frame.positions, nowMs, goesOn);
    if (frame.topology) Object.assign(this, frame.topology);
    this.epoch = frame.epoch;
    this.tick = frame.tick;
    this.topologyVersion = frame.topologyVersion;
    this.numVertices = count / 3;
    this.numSlots = frame.numSlots;
    this.numPieces = frame.numPieces;
    this.takeStrains(frame.strains);
    this.probeValues = frame.probeValues;
    if (frame.probeColumns) this.probeColumns = frame.probeColumns;
    if (frame.stats) this.stats = frame.stats;
  }

  private takeStrains(strains: Float32Array | undefined): void {
    if (!strains) {
      this.strains = undefined;
      return;
    }
    if (this.strains?.length !== strains.length) {
      if (this.strainRoom.length < strains.length) this.strainRoom = new Float32Array(strains.length);
      this.strains = this.strainRoom.subarray(0, strains.length);
    }
    this.strains.set(strains);
  }

  /** Moves `positions` to `nowMs`; true if they have changed. */
  advance(nowMs: number): boolean {
    return this.interpolation.advance(this.positions, nowMs);
  }
}
