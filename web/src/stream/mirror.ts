import type { Frame, FrameStats, TopologyPatch } from '../gen/kerf/v1/stream_pb';
import { addZigzagDeltas } from './varint';

/** A frame that does not follow from the mirror's state, or is malformed. The stream must be started anew. */
export class MirrorError extends Error {
  override readonly name = 'MirrorError';
}

function require(condition: boolean, message: () => string): asserts condition {
  if (!condition) throw new MirrorError(message());
}

/** Array with room for `count` elements and the first `used` of `array` kept; grows by doubling. */
function withRoom<T extends Int32Array | Float32Array | Uint16Array>(array: T, used: number, count: number): T {
  if (array.length >= count) return array;
  const grown = new (array.constructor as new (length: number) => T)(Math.max(count, 2 * array.length));
  grown.set(array.subarray(0, used) as never);
  return grown;
}

// Bytes fields are views into the message at any alignment: copy before viewing them as wider numbers. Typed arrays
// have the machine's byte order, which is little-endian, as on the wire, everywhere that browsers run.
function aligned(bytes: Uint8Array): ArrayBuffer {
  return bytes.slice().buffer as ArrayBuffer;
}

/**
 * The viewer's copy of a sheet: applies kerf.v1.Frame messages, keyframes, deltas and topology patches, in the order of
 * the stream. `apply` does all of a frame or, throwing MirrorError, nothing.
 *
 * The arrays have spare room at the end; only the stated parts are valid.
 */
export class SheetMirror {
  /** Of the last frame; 0 before the first. */
  sequence = 0;
  /** Of the last frame; -1 before the first. */
  tick = -1;
  /** -1 before the first. */
  topologyVersion = -1;
  /** V */
  numVertices = 0;
  /** S, empty slots included */
  numSlots = 0;
  /** Of the whole sheet. */
  numPieces = 0;
  /** 3 V: x, y, z interleaved, metres, world */
  positions: Float32Array = new Float32Array(0);
  /** 2 V: x, y interleaved, metres */
  materialPositions: Float32Array = new Float32Array(0);
  /** 3 S vertex ids, counter-clockwise in material coordinates; (-1, -1, -1) for an empty slot */
  triangles: Int32Array = new Int32Array(0);
  /** S, -1 for an empty slot */
  pieces: Int32Array = new Int32Array(0);
  /** Of the last frame that had any. */
  stats: FrameStats | undefined;

  // q of stream.proto: 3 V, and the buffer that the next frame is decoded into.
  private quantised: Uint16Array = new Uint16Array(0);
  private next: Uint16Array = new Uint16Array(0);
  private readonly boxMin = [0, 0, 0];
  private readonly boxStep = [0, 0, 0];

  apply(frame: Frame): void {
    const sequence = Number(frame.sequence);
    require(sequence === this.sequence + 1, () => `frame ${sequence} after frame ${this.sequence}`);
    const isKeyframe = frame.baseTick === -1n;
    require(isKeyframe || (this.tick >= 0 && Number(frame.baseTick) === this.tick), () =>
      `delta against tick ${frame.baseTick}, but the mirror is at ${this.tick}`);
    require(frame.numVertices >= 0, () => `${frame.numVertices} vertices`);
    this.checkTopology(frame);
    this.decodePositions(frame, isKeyframe);

    // Nothing fails from here on.
    if (frame.topology) this.applyTopology(frame.topology, frame.numVertices);
    this.commitPositions(frame, isKeyframe);
    this.sequence = sequence;
    this.tick = Number(frame.tick);
    this.topologyVersion = frame.topologyVersion;
    if (frame.stats) this.stats = frame.stats;
  }

  private decodePositions(frame: Frame, isKeyframe: boolean): void {
    const count = 3 * frame.numVertices;
    this.next = withRoom(this.next, 0, count);
    if (isKeyframe) {
      require(frame.box?.min !== undefined && frame.box.max !== undefined, () => 'keyframe without a box');
      require(frame.positions.length === 2 * count, () =>
        `keyframe of ${frame.numVertices} vertices has ${frame.positions.length} bytes of positions`);
      this.next.set(new Uint16Array(aligned(frame.positions)));
      return;
    }
    try {
      addZigzagDeltas(frame.positions, this.quantised, 3 * this.numVertices, this.next, count);
    } catch (error) {
      throw new MirrorError(`delta of tick ${frame.tick}: ${(error as Error).message}`);
    }
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

  private checkTopology(frame: Frame): void {
    const patch = frame.topology;
    if (!patch) {
      require(frame.topologyVersion === this.topologyVersion, () =>
        `topology ${frame.topologyVersion} without a patch; the mirror has ${this.topologyVersion}`);
      require(frame.numVertices === this.numVertices, () =>
        `${frame.numVertices} vertices without a patch; the mirror has ${this.numVertices}`);
      return;
    }
    const isFull = patch.baseVersion === -1;
    require(isFull || patch.baseVersion === this.topologyVersion, () =>
      `patch against topology ${patch.baseVersion}; the mirror has ${this.topologyVersion}`);
    require(isFull || frame.numVertices >= this.numVertices, () => 'a patch that is not full removes vertices');
    require(patch.numSlots >= 0, () => `${patch.numSlots} slots`);
    require(!isFull || (patch.slots.length === 0 && patch.vertices.length === 0), () =>
      'a full patch lists slots or vertices');
    this.checkSlots(patch, isFull, frame.numVertices);
    this.checkVertices(patch, isFull, frame.numVertices);
  }

  private checkSlots(patch: TopologyPatch, isFull: boolean, numVertices: number): void {
    const changed = isFull ? patch.numSlots : patch.slots.length / 4;
    require(patch.triangles.length === 12 * changed && patch.pieces.length === 4 * changed, () =>
      `${changed} changed slots with ${patch.triangles.length} bytes of triangles, ${patch.pieces.length} of pieces`);
    checkAscending(patch.slots, patch.numSlots, 'slot');
    const triangles = new Int32Array(aligned(patch.triangles));
    for (let i = 0; i < triangles.length; i += 3) {
      const [a, b, c] = [triangles[i], triangles[i + 1], triangles[i + 2]];
      const isEmpty = a === -1 && b === -1 && c === -1;
      const isInside = Math.min(a, b, c) >= 0 && Math.max(a, b, c) < numVertices;
      require(isEmpty || isInside, () => `triangle (${a}, ${b}, ${c}) of ${numVertices} vertices`);
    }
  }

  private checkVertices(patch: TopologyPatch, isFull: boolean, numVertices: number): void {
    const changed = isFull ? numVertices : patch.vertices.length / 4;
    require(patch.materialPositions.length === 8 * changed, () =>
      `${changed} vertices with ${patch.materialPositions.length} bytes of material positions`);
    const vertices = checkAscending(patch.vertices, numVertices, 'vertex');
    if (isFull) return;
    const numNew = numVertices - this.numVertices;
    require(numNew === 0 || vertices[vertices.length - numNew] === this.numVertices, () =>
      `new vertices ${this.numVertices}..${numVertices - 1} are not all listed`);
  }

  private applyTopology(patch: TopologyPatch, numVertices: number): void {
    const isFull = patch.baseVersion === -1;
    const keptSlots = isFull ? 0 : Math.min(this.numSlots, patch.numSlots);
    this.triangles = withRoom(this.triangles, 3 * keptSlots, 3 * patch.numSlots);
    this.pieces = withRoom(this.pieces, keptSlots, patch.numSlots);
    this.materialPositions = withRoom(this.materialPositions, isFull ? 0 : 2 * this.numVertices, 2 * numVertices);
    const triangles = new Int32Array(aligned(patch.triangles));
    const pieces = new Int32Array(aligned(patch.pieces));
    const material = new Float32Array(aligned(patch.materialPositions));
    if (isFull) {
      this.triangles.set(triangles);
      this.pieces.set(pieces);
      this.materialPositions.set(material);
    } else {
      this.triangles.fill(-1, 3 * keptSlots, 3 * patch.numSlots);
      this.pieces.fill(-1, keptSlots, patch.numSlots);
      new Uint32Array(aligned(patch.slots)).forEach((slot, i) => {
        this.triangles.set(triangles.subarray(3 * i, 3 * i + 3), 3 * slot);
        this.pieces[slot] = pieces[i];
      });
      new Uint32Array(aligned(patch.vertices)).forEach((vertex, i) => {
        this.materialPositions[2 * vertex] = material[2 * i];
        this.materialPositions[2 * vertex + 1] = material[2 * i + 1];
      });
    }
    this.numSlots = patch.numSlots;
    this.numPieces = patch.numPieces;
  }
}

function checkAscending(bytes: Uint8Array, limit: number, what: string): Uint32Array {
  require(bytes.length % 4 === 0, () => `${bytes.length} bytes of ${what} ids`);
  const ids = new Uint32Array(aligned(bytes));
  for (let i = 0; i < ids.length; ++i) {
    require(ids[i] < limit, () => `${what} ${ids[i]} of ${limit}`);
    require(i === 0 || ids[i] > ids[i - 1], () => `${what} ${ids[i]} after ${ids[i - 1]}`);
  }
  return ids;
}
