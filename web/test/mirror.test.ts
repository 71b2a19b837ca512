import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { Encoding, FrameSchema } from '../src/gen/kerf/v1/stream_pb';
import type { Frame } from '../src/gen/kerf/v1/stream_pb';
import { MirrorError, SheetMirror } from '../src/stream/mirror';

const kBox = { min: { x: -1, y: 0, z: 2 }, max: { x: 1, y: 0.5, z: 6 } };
const kFirst = [0, 0, 0, 65535, 0, 0, 65535, 65535, 32768, 0, 65535, 65535];
const kSecond = [0, 0, 0, 65534, 64, 0, 0, 65235, 32769, 5, 0, 65535, 40000, 2, 65535];

const packed = (values: ArrayLike<number> & { buffer: ArrayBufferLike }) => new Uint8Array(values.buffer.slice(0));
const shorts = (values: number[]) => packed(Uint16Array.from(values));
const words = (values: number[]) => packed(Int32Array.from(values));
const floats = (values: number[]) => packed(Float32Array.from(values));

// Raw frames by hand after stream.proto. First: tick 7, four vertices, slots (0 1 2), empty, (0 2 3).
function firstFrame(): Frame {
  return create(FrameSchema, {
    sequence: 1n,
    tick: 7n,
    baseTick: -1n,
    topologyVersion: 3,
    numVertices: 4,
    box: kBox,
    encoding: Encoding.RAW,
    positions: shorts(kFirst),
    topology: {
      baseVersion: -1,
      numSlots: 3,
      numListedSlots: 3,
      numListedVertices: 4,
      triangles: words([0, 1, 2, -1, -1, -1, 0, 2, 3]),
      pieces: words([0, -1, 0]),
      materialPositions: floats([0, 0, 1, 0, 1, 0.5, 0, 0.5]),
      numPieces: 1,
    },
    stats: { publishedUnixUs: 1700000000000000n },
  });
}

// Second: tick 9. Vertex 4 is new, vertex 3 moves in material coordinates, slots 1, 2, 3 change, 2 pieces.
function secondFrame(): Frame {
  return create(FrameSchema, {
    sequence: 2n,
    tick: 9n,
    baseTick: -1n,
    topologyVersion: 4,
    numVertices: 5,
    box: kBox,
    encoding: Encoding.RAW,
    positions: shorts(kSecond),
    topology: {
      baseVersion: 3,
      numSlots: 4,
      numListedSlots: 3,
      numListedVertices: 2,
      slots: words([1, 2, 3]),
      triangles: words([0, 2, 4, -1, -1, -1, 0, 4, 3]),
      pieces: words([0, -1, 1]),
      vertices: words([3, 4]),
      materialPositions: floats([0.125, 0.5, 0.5, 0.5]),
      numPieces: 2,
    },
    stats: { settingsVersion: 5 },
  });
}

function state(mirror: SheetMirror) {
  return {
    tick: mirror.tick,
    topologyVersion: mirror.topologyVersion,
    positions: [...mirror.positions.subarray(0, 3 * mirror.numVertices)],
    material: [...mirror.materialPositions.subarray(0, 2 * mirror.numVertices)],
    triangles: [...mirror.triangles.subarray(0, 3 * mirror.numSlots)],
    pieces: [...mirror.pieces.subarray(0, mirror.numSlots)],
    numPieces: mirror.numPieces,
  };
}

function world(q: number[]): number[] {
  const [min, max] = [
    [-1, 0, 2],
    [1, 0.5, 6],
  ];
  return q.map((value, i) => Math.fround(min[i % 3] + (value * (max[i % 3] - min[i % 3])) / 65535));
}

describe('SheetMirror', () => {
  it('takes a keyframe with a full topology', () => {
    const mirror = new SheetMirror();
    mirror.apply(firstFrame());
    expect(state(mirror)).toEqual({
      tick: 7,
      topologyVersion: 3,
      positions: world(kFirst),
      material: [0, 0, 1, 0, 1, 0.5, 0, 0.5],
      triangles: [0, 1, 2, -1, -1, -1, 0, 2, 3],
      pieces: [0, -1, 0],
      numPieces: 1,
    });
    expect(mirror.stats?.publishedUnixUs).toBe(1700000000000000n);
  });

  it('takes a frame with a topology patch', () => {
    const mirror = new SheetMirror();
    mirror.apply(firstFrame());
    mirror.apply(secondFrame());
    expect(state(mirror)).toEqual({
      tick: 9,
      topologyVersion: 4,
      positions: world(kSecond),
      material: [0, 0, 1, 0, 1, 0.5, 0.125, 0.5, 0.5, 0.5],
      triangles: [0, 1, 2, 0, 2, 4, -1, -1, -1, 0, 4, 3],
      pieces: [0, 0, -1, 1],
      numPieces: 2,
    });
    expect(mirror.stats?.settingsVersion).toBe(5);
  });

  it('takes a keyframe of positions alone', () => {
    const mirror = new SheetMirror();
    mirror.apply(firstFrame());
    const next = { ...firstFrame(), sequence: 2n, tick: 8n, topology: undefined, positions: new Uint8Array(24) };
    mirror.apply(create(FrameSchema, next));
    expect(state(mirror).positions).toEqual(world(new Array(12).fill(0)));
    expect(mirror.numPieces).toBe(1);
  });

  it('starts from nothing with a full patch that has fewer vertices and slots', () => {
    const mirror = new SheetMirror();
    mirror.apply(firstFrame());
    mirror.apply(secondFrame());
    mirror.apply(create(FrameSchema, { ...firstFrame(), sequence: 3n, tick: 10n, topologyVersion: 5 }));
    expect(mirror.numVertices).toBe(4);
    expect(state(mirror).triangles).toEqual([0, 1, 2, -1, -1, -1, 0, 2, 3]);
  });

  const good = () => secondFrame();
  const refused: [string, (frame: Frame) => void][] = [
    ['a gap in the sequence', (f) => (f.sequence = 3n)],
    ['a delta against another tick', (f) => Object.assign(f, { baseTick: 6n, encoding: Encoding.COMPACT })],
    ['a raw delta', (f) => (f.baseTick = 7n)],
    ['an encoding that is not known', (f) => (f.encoding = Encoding.ENCODING_UNSPECIFIED)],
    ['compact bytes that are none', (f) => (f.encoding = Encoding.COMPACT)],
    ['a patch against another topology', (f) => (f.topology!.baseVersion = 2)],
    ['another topology without a patch', (f) => (f.topology = undefined)],
    ['positions that end early', (f) => (f.positions = f.positions.subarray(0, -1))],
    ['positions that end late', (f) => (f.positions = new Uint8Array([...f.positions, 0]))],
    ['a triangle of a vertex that is not there', (f) => (f.topology!.triangles = words([0, 2, 5, -1, -1, -1, 0, 4, 3]))],
    ['a triangle that is half empty', (f) => (f.topology!.triangles = words([0, 2, -1, -1, -1, -1, 0, 4, 3]))],
    ['slots out of order', (f) => (f.topology!.slots = words([1, 3, 2]))],
    ['a slot out of range', (f) => (f.topology!.slots = words([1, 2, 4]))],
    ['fewer triangles than slots', (f) => (f.topology!.triangles = words([0, 2, 4]))],
    ['a new vertex that is not listed', (f) => (f.topology!.vertices = words([2, 3]))],
    ['fewer material positions than vertices', (f) => (f.topology!.materialPositions = new Uint8Array(8))],
    ['vertices that vanish', (f) => (f.numVertices = 3)],
    ['values of probes without their names', (f) => (f.probeValues = [1])],
    ['a keyframe without a box', (f) => Object.assign(f, { box: undefined })],
  ];
  it.each(refused)('refuses %s and stays as it was', (_, spoil) => {
    const mirror = new SheetMirror();
    mirror.apply(firstFrame());
    const before = state(mirror);
    const frame = good();
    spoil(frame);
    expect(() => mirror.apply(frame)).toThrow(MirrorError);
    expect(state(mirror)).toEqual(before);
    mirror.apply(good());
    expect(mirror.tick).toBe(9);
  });

  it('follows an undo: a full topology with fewer vertices and slots, and a patch after it', () => {
    const mirror = new SheetMirror();
    mirror.apply(firstFrame());
    const before = state(mirror);
    mirror.apply(good());
    expect(mirror.numVertices).toBe(5);
    mirror.apply(create(FrameSchema, { ...firstFrame(), sequence: 3n, tick: 9n, topologyVersion: 6 }));
    expect(state(mirror)).toEqual({ ...before, tick: 9, topologyVersion: 6 });
    const again = good();
    Object.assign(again, { sequence: 4n, tick: 10n, topologyVersion: 7 });
    again.topology!.baseVersion = 6;
    mirror.apply(again);
    const twice = new SheetMirror();
    twice.apply(firstFrame());
    twice.apply(good());
    expect(state(mirror)).toEqual({ ...state(twice), tick: 10, topologyVersion: 7 });
  });

  it('refuses a delta as the first frame', () => {
    expect(() => new SheetMirror().apply(create(FrameSchema, { ...good(), sequence: 1n, baseTick: 7n }))).toThrow(MirrorError);
  });
});
