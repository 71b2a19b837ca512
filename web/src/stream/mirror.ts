import { Encoding } from '../gen/kerf/v1/stream_pb';
import type { Frame, FrameStats, TopologyPatch } from '../gen/kerf/v1/stream_pb';
import {
  unpackAscending,
  unpackBytes,
  unpackLabels,
  unpackMaterialPositions,
  unpackPositions,
  unpackTriangles,
} from './frame_code';
import { CodeError } from './packed_integers';
import { vertexPredictors } from './predictors';
import type { Predictors } from './predictors';

/** A frame that does not follow from the mirror's state, or is malformed. The stream must be started again. */
export class MirrorError extends Error {
  override readonly name = 'MirrorError';
}

function require(condition: boolean, message: () => string): asserts condition {
  if (!condition) throw new MirrorError(message());
}

/** Returns an array with room for `count` elements that keeps the first `used` of `array`; it grows by doubling. */
function withRoom<T extends Int32Array | Float32Array | Uint16Array | Uint32Array>(array: T, used: number, count: number): T {
  if (array.length >= count) return array;
  const grown = new (array.constructor as new (length: number) => T)(Math.max(count, 2 * array.length));
  grown.set(array.subarray(0, used) as never);
  return grown;
}

/** Returns a copy of the first `used` elements with room for `count`. */
function kept<T extends Int32Array | Float32Array>(array: T, used: number, count: number): T {
  const copy = new (array.constructor as new (length: number) => T)(count);
  copy.set(array.subarray(0, used) as never);
  return copy;
}

// Bytes fields are views into the message at any alignment: copy before viewing them as wider numbers. Typed arrays
// have the machine's byte order, which is little-endian, as on the wire, everywhere that browsers run.
function aligned(bytes: Uint8Array): ArrayBuffer {
  return bytes.slice().buffer as ArrayBuffer;
}

/** A topology read from a frame, before the mirror takes it. */
interface Topology {
  numSlots: number;
  numPieces: number;
  triangles: Int32Array;
  pieces: Int32Array;
  material: Float32Array;
  /** Present for compact frames. */
  predictors: Predictors | undefined;
}

/**
 * The viewer's copy of a sheet. Applies kerf.v1.Frame messages (keyframes, deltas and topology patches) in the order of
 * the stream. `apply` applies a frame completely, or throws MirrorError and changes nothing.
 *
 * The arrays may have spare room at the end; only the stated lengths are valid. A frame with a topology makes new
 * arrays of triangles, pieces and material positions.
 */
export class SheetMirror {
  /** Sequence number of the last frame; 0 before the first. */
  sequence = 0;
  /** Tick of the last frame; -1 before the first. */
  tick = -1;
  /** Version of the topology; -1 before the first frame. */
  topologyVersion = -1;
  /** V */
  numVertices = 0;
  /** S, empty slots included */
  numSlots = 0;
  /** Number of pieces of the whole sheet. */
  numPieces = 0;
  /** 3 V: x, y, z interleaved, metres, world */
  positions: Float32Array = new Float32Array(0);
  /** 2 V: x, y interleaved, metres */
  materialPositions: Float32Array = new Float32Array(0);
  /** 3 S vertex ids, counter-clockwise in material coordinates; (-1, -1, -1) for an empty slot */
  triangles: Int32Array = new Int32Array(0);
  /** S, -1 for an empty slot */
  pieces: Int32Array = new Int32Array(0);
  /**
   * V principal strains of the largest magnitude, -, in an array of exactly this length; undefined if the last frame
   * had none
   */
  strains: Float32Array | undefined;
  /** Values of the stream's probes at `tick`, one for each of `probeColumns`; NaN where there is nothing to measure. */
  probeValues: readonly number[] = [];
  /** Names of the values, such as "tip.x"; empty without probes. */
  probeColumns: readonly string[] = [];
  /** Stats of the last frame that had any. */
  stats: FrameStats | undefined;

  // Quantised positions (q of stream.proto), 3 V, and the buffer into which the next frame is decoded.
  private quantised: Uint16Array = new Uint16Array(0);
  private next: Uint16Array = new Uint16Array(0);
  // Buffers into which the numbers of a frame are unpacked.
  private unpacked: Uint32Array = new Uint32Array(0);
  private strainRoom: Float32Array = new Float32Array(0);
  private predictors: Predictors | undefined;
  private readonly boxMin = [0, 0, 0];
  private readonly boxStep = [0, 0, 0];

  /** Epoch of the frame with which the sheet began, in this stream; empty before the first. See stream.proto. */
  epoch = '';

  /** Returns a mirror for another stream, which may continue from the topology of this one. The two share arrays. */
  resumed(): SheetMirror {
    const next = new SheetMirror();
    Object.assign(next, { ...this, sequence: 0, tick: -1, quantised: new Uint16Array(0), next: new Uint16Array(0) });
    next.strainRoom = new Float32Array(0);
    next.positions = this.positions.slice();
    next.probeValues = next.probeColumns = [];
    return next;
  }

  /** Returns a mirror with the same state. Applying frames to one does not change the other's arrays. */
  copy(): SheetMirror {
    const copy = new SheetMirror();
    Object.assign(copy, this, {
      positions: this.positions.slice(0, 3 * this.numVertices),
      quantised: this.quantised.slice(0, 3 * this.numVertices),
      next: new Uint16Array(0),
      unpacked: new Uint32Array(0),
      strains: this.strains?.slice(),
      strainRoom: new Float32Array(0),
      boxMin: [...this.boxMin],
      boxStep: [...this.boxStep],
    });
    return copy;
  }

  /** Makes the next stream begin with the whole topology. */
  forgetEpoch(): void {
    this.epoch = '';
  }

  /** 3 V: x, y, z interleaved, 0..65535 in the last keyframe's box */
  get quantisedPositions(): Uint16Array {
    return this.quantised.subarray(0, 3 * this.numVertices);
  }

  apply(frame: Frame): void {
    const sequence = Number(frame.sequence);
    require(sequence === this.sequence + 1, () => `frame ${sequence} after frame ${this.sequence}`);
    const isKeyframe = frame.baseTick === -1n;
    require(isKeyframe || (this.tick >= 0 && Number(frame.baseTick) === this.tick), () =>
      `delta against tick ${frame.baseTick}, but the mirror is at ${this.tick}`);
    require(frame.numVertices >= 0, () => `${frame.numVertices} vertices`);
    const probeColumns = frame.probeColumns.length > 0 ? frame.probeColumns : this.probeColumns;
    require(frame.probeValues.length === probeColumns.length, () =>
      `${frame.probeValues.length} values of probes for ${probeColumns.length} columns`);
    let topology: Topology | undefined;
    let strains: Int8Array | undefined;
    try {
      if (frame.topology) topology = this.patched(frame, frame.topology);
      else this.checkUnchanged(frame);
      const predictors = () => topology?.predictors ?? this.ownPredictors();
      this.decodePositions(frame, isKeyframe, predictors);
      strains = readStrains(frame, predictors, this.unpacked);
    } catch (error) {
      throw error instanceof CodeError ? new MirrorError(`frame of tick ${frame.tick}: ${error.message}`) : error;
    }

    // Nothing can fail from here on.
    if (topology) this.commitTopology(topology);
    this.commitPositions(frame, isKeyframe);
    this.strains = strains && this.scaledStrains(strains, frame.strainScale);
    this.probeColumns = probeColumns;
    this.probeValues = frame.probeValues;
    if (frame.epoch !== '') this.epoch = frame.epoch;
    this.sequence = sequence;
    this.tick = Number(frame.tick);
    this.topologyVersion = frame.topologyVersion;
    if (frame.stats) this.stats = frame.stats;
  }

  private ownPredictors(): Predictors {
    this.predictors ??= vertexPredictors(this.triangles, this.numSlots, this.numVertices);
    return this.predictors;
  }

  private decodePositions(frame: Frame, isKeyframe: boolean, predictors: () => Predictors): void {
    const count = 3 * frame.numVertices;
    require(!isKeyframe || (frame.box?.min !== undefined && frame.box.max !== undefined), () =>
      'keyframe without a box');
    if (frame.encoding === Encoding.COMPACT) {
      const baseCount = isKeyframe ? 0 : 3 * this.numVertices;
      this.next = withRoom(this.next, 0, count);
      this.unpacked = withRoom(this.unpacked, 0, count);
      unpackPositions(frame.positions, this.quantised, baseCount, predictors(), this.next, this.unpacked);
      return;
    }
    require(frame.encoding === Encoding.RAW && isKeyframe, () => `frame of encoding ${frame.encoding}`);
    require(frame.positions.length === 2 * count, () =>
      `keyframe of ${frame.numVertices} vertices has ${frame.positions.length} bytes of positions`);
    this.next = withRoom(this.next, 0, count);
    this.next.set(new Uint16Array(aligned(frame.positions)));
  }

  private commitPositions(frame: Frame, isKeyframe: boolean): void {
    if (isKeyframe) {
      const { min, max } = frame.box!;
      [min!.x, min!.y, min!.z].forEach((value, axis) => (this.boxMin[axis] = value));
      [max!.x, max!.y, max!.z].forEach((value, axis) => (this.boxStep[axis] = (value - this.boxMin[axis]) / 65535));
    }
    [this.quantised, this.next] = [this.next, this.quantised];
    this.numVertices = frame.numVertices;
    const count = 3 * frame.numVertices;
    this.positions = withRoom(this.positions, 0, count);
    const { positions, quantised } = this;
    const [minX, minY, minZ] = this.boxMin;
    const [stepX, stepY, stepZ] = this.boxStep;
    for (let i = 0; i < count; i += 3) {
      positions[i] = minX + quantised[i] * stepX;
      positions[i + 1] = minY + quantised[i + 1] * stepY;
      positions[i + 2] = minZ + quantised[i + 2] * stepZ;
    }
  }

  private scaledStrains(quantised: Int8Array, scale: number): Float32Array {
    const { length } = quantised;
    this.strainRoom = withRoom(this.strainRoom, 0, length);
    for (let v = 0; v < length; ++v) {
      const share = quantised[v] / 127;
      this.strainRoom[v] = share * Math.abs(share) * scale;
    }
    return this.strains?.buffer === this.strainRoom.buffer && this.strains.length === length
      ? this.strains
      : this.strainRoom.subarray(0, length);
  }

  private checkUnchanged(frame: Frame): void {
    require(frame.topologyVersion === this.topologyVersion, () =>
      `topology ${frame.topologyVersion} without a patch; the mirror has ${this.topologyVersion}`);
    require(frame.numVertices === this.numVertices, () =>
      `${frame.numVertices} vertices without a patch; the mirror has ${this.numVertices}`);
  }

  /** Returns the topology after the frame's patch, in new arrays. */
  private patched(frame: Frame, patch: TopologyPatch): Topology {
    const isFull = patch.baseVersion === -1;
    require(isFull || patch.baseVersion === this.topologyVersion, () =>
      `patch against topology ${patch.baseVersion}; the mirror has ${this.topologyVersion}`);
    require(isFull || frame.numVertices >= this.numVertices, () => 'a patch that is not full removes vertices');
    require(patch.numSlots >= 0, () => `${patch.numSlots} slots`);
    const read = readPatch(frame, patch, isFull);
    this.checkNewVertices(read.vertices, frame.numVertices, isFull);

    const keptSlots = isFull ? 0 : Math.min(this.numSlots, patch.numSlots);
    const keptVertices = isFull ? 0 : this.numVertices;
    const triangles = kept(this.triangles, 3 * keptSlots, 3 * patch.numSlots).fill(-1, 3 * keptSlots);
    const pieces = kept(this.pieces, keptSlots, patch.numSlots).fill(-1, keptSlots);
    const material = kept(this.materialPositions, 2 * keptVertices, 2 * frame.numVertices);
    read.slots.forEach((slot, i) => {
      triangles.set(read.triangles.subarray(3 * i, 3 * i + 3), 3 * slot);
      pieces[slot] = read.pieces[i];
    });
    let predictors: Predictors | undefined;
    if (frame.encoding === Encoding.COMPACT) {
      predictors = vertexPredictors(triangles, patch.numSlots, frame.numVertices);
      unpackMaterialPositions(patch.materialPositions, read.vertices, predictors, material);
    } else {
      require(patch.materialPositions.length === 8 * read.vertices.length, () =>
        `${read.vertices.length} vertices with ${patch.materialPositions.length} bytes of material positions`);
      const packed = new Float32Array(aligned(patch.materialPositions));
      read.vertices.forEach((vertex, i) => material.set(packed.subarray(2 * i, 2 * i + 2), 2 * vertex));
    }
    return { numSlots: patch.numSlots, numPieces: patch.numPieces, triangles, pieces, material, predictors };
  }

  private checkNewVertices(vertices: Uint32Array, numVertices: number, isFull: boolean): void {
    const numNew = isFull ? 0 : numVertices - this.numVertices;
    require(numNew === 0 || vertices[vertices.length - numNew] === this.numVertices, () =>
      `new vertices ${this.numVertices}..${numVertices - 1} are not all listed`);
  }

  private commitTopology(topology: Topology): void {
    this.triangles = topology.triangles;
    this.pieces = topology.pieces;
    this.materialPositions = topology.material;
    this.predictors = topology.predictors;
    this.numSlots = topology.numSlots;
    this.numPieces = topology.numPieces;
  }
}

/** Returns the quantised strains (q of stream.proto), one per vertex. */
function readStrains(frame: Frame, predictors: () => Predictors, room: Uint32Array): Int8Array | undefined {
  if (frame.strainScale === 0) {
    require(frame.strains.length === 0, () => 'strains without a scale');
    return undefined;
  }
  const isCompact = frame.encoding === Encoding.COMPACT;
  require(isCompact || frame.strains.length === frame.numVertices, () =>
    `${frame.strains.length} strains of ${frame.numVertices} vertices`);
  return isCompact ? unpackBytes(frame.strains, predictors(), room) : new Int8Array(aligned(frame.strains));
}

/** Lists of a patch: slots with their triangles and pieces, and vertices. */
interface ReadPatch {
  slots: Uint32Array;
  triangles: Int32Array;
  pieces: Int32Array;
  vertices: Uint32Array;
}

function readPatch(frame: Frame, patch: TopologyPatch, isFull: boolean): ReadPatch {
  const { numListedSlots: n, numListedVertices: m } = patch;
  require(n >= 0 && m >= 0, () => `${n} slots and ${m} vertices listed`);
  require(!isFull || (n === patch.numSlots && m === frame.numVertices), () => 'a full patch lists not all');
  require(!isFull || (patch.slots.length === 0 && patch.vertices.length === 0), () =>
    'a full patch lists slots or vertices');
  const isCompact = frame.encoding === Encoding.COMPACT;
  const words = (bytes: Uint8Array, count: number, what: string) => {
    require(bytes.length === 4 * count, () => `${what} of ${n} slots and ${m} vertices have ${bytes.length} bytes`);
    return new Int32Array(aligned(bytes));
  };
  const ids = (bytes: Uint8Array, count: number, what: string) =>
    isCompact ? unpackAscending(bytes, count) : new Uint32Array(words(bytes, count, what).buffer);
  // Reads triangles and pieces first: their bytes bound the counts before lists of all ids are made.
  const triangles = isCompact
    ? unpackTriangles(patch.triangles, n, isFull)
    : words(patch.triangles, 3 * n, 'triangles');
  const pieces = isCompact ? unpackLabels(patch.pieces, n) : words(patch.pieces, n, 'pieces');
  const slots = isFull ? Uint32Array.from({ length: n }, (_, i) => i) : ids(patch.slots, n, 'ids');
  const vertices = isFull ? Uint32Array.from({ length: m }, (_, i) => i) : ids(patch.vertices, m, 'ids');
  checkAscending(slots, patch.numSlots, 'slot');
  checkAscending(vertices, frame.numVertices, 'vertex');
  for (let i = 0; i < triangles.length; i += 3) {
    const [a, b, c] = [triangles[i], triangles[i + 1], triangles[i + 2]];
    const isEmpty = a === -1 && b === -1 && c === -1;
    const isInside = Math.min(a, b, c) >= 0 && Math.max(a, b, c) < frame.numVertices;
    require(isEmpty || isInside, () => `triangle (${a}, ${b}, ${c}) of ${frame.numVertices} vertices`);
  }
  return { slots, triangles, pieces, vertices };
}

function checkAscending(ids: Uint32Array, limit: number, what: string): void {
  for (let i = 0; i < ids.length; ++i) {
    require(ids[i] < limit, () => `${what} ${ids[i]} of ${limit}`);
    require(i === 0 || ids[i] > ids[i - 1], () => `${what} ${ids[i]} after ${ids[i - 1]}`);
  }
}
