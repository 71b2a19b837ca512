import { create, fromBinary } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { FrameSchema, WatchResponseSchema } from '../src/gen/kerf/v1/stream_pb';
import type { Frame } from '../src/gen/kerf/v1/stream_pb';
import { MirrorError, SheetMirror } from '../src/stream/mirror';
import { addZigzagDeltas } from '../src/stream/varint';

// Two messages as `protoc --encode=kerf.v1.WatchResponse` wrote them, positions and arrays packed by hand after
// stream.proto. First: tick 7, four vertices, slots (0 1 2), empty, (0 2 3), box (-1, 0, 2)..(1, 0.5, 2).
const kKeyframe =
  '0ae1010801100718ffffffffffffffffff012003280432310a1209000000000000f0bf190000000000000040121b09000000000000f03f11' +
  '000000000000e03f1900000000000000403a18000000000000ffff00000000ffffffff00800000ffffffff426508ffffffffffffffffff01' +
  '10032224000000000100000002000000ffffffffffffffffffffffff0000000002000000030000002a0c00000000ffffffff000000003a20' +
  '00000000000000000000803f000000000000803f0000003f000000000000003f40014a1811000000000000f03f308080f9c0c1c482033801' +
  '40024805';
// Second: tick 9 against 7. Vertex 4 is new, vertex 3 moves in material coordinates, slots 1, 2, 3 change, 2 pieces.
const kDelta =
  '0a8b01080210091807200428053a1900000001800100fdff07d704020afdff070080f10404feff074264080310041a0c0100000002000000' +
  '030000002224000000000200000004000000ffffffffffffffffffffffff0000000004000000030000002a0c00000000ffffffff01000000' +
  '320803000000040000003a100000003e0000003f0000003f0000003f4002';

function frameOf(hex: string): Frame {
  const { kind } = fromBinary(WatchResponseSchema, Uint8Array.from(Buffer.from(hex, 'hex')));
  if (kind.case !== 'frame') throw new Error('not a frame');
  return kind.value;
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
    [1, 0.5, 2],
  ];
  return q.map((value, i) => Math.fround(min[i % 3] + (value * (max[i % 3] - min[i % 3])) / 65535));
}

describe('SheetMirror', () => {
  it('takes a keyframe with a full topology', () => {
    const mirror = new SheetMirror();
    mirror.apply(frameOf(kKeyframe));
    expect(state(mirror)).toEqual({
      tick: 7,
      topologyVersion: 3,
      positions: world([0, 0, 0, 65535, 0, 0, 65535, 65535, 32768, 0, 65535, 65535]),
      material: [0, 0, 1, 0, 1, 0.5, 0, 0.5],
      triangles: [0, 1, 2, -1, -1, -1, 0, 2, 3],
      pieces: [0, -1, 0],
      numPieces: 1,
    });
    expect(mirror.stats?.publishedUnixUs).toBe(1700000000000000n);
  });

  it('takes a delta with a topology patch', () => {
    const mirror = new SheetMirror();
    mirror.apply(frameOf(kKeyframe));
    mirror.apply(frameOf(kDelta));
    expect(state(mirror)).toEqual({
      tick: 9,
      topologyVersion: 4,
      positions: world([0, 0, 0, 65534, 64, 0, 0, 65235, 32769, 5, 0, 65535, 40000, 2, 65535]),
      material: [0, 0, 1, 0, 1, 0.5, 0.125, 0.5, 0.5, 0.5],
      triangles: [0, 1, 2, 0, 2, 4, -1, -1, -1, 0, 4, 3],
      pieces: [0, 0, -1, 1],
      numPieces: 2,
    });
    expect(mirror.stats?.settingsVersion).toBe(5);
  });

  it('takes a keyframe of positions alone, and a delta without changes of topology', () => {
    const mirror = new SheetMirror();
    mirror.apply(frameOf(kKeyframe));
    const keyframe = frameOf(kKeyframe);
    mirror.apply(
      create(FrameSchema, { ...keyframe, sequence: 2n, tick: 8n, topology: undefined, positions: new Uint8Array(24) }),
    );
    expect(state(mirror).positions).toEqual(world(new Array(12).fill(0)));
    mirror.apply(
      create(FrameSchema, {
        sequence: 3n,
        tick: 9n,
        baseTick: 8n,
        topologyVersion: 3,
        numVertices: 4,
        positions: new Uint8Array(12).fill(2),
      }),
    );
    expect(state(mirror).positions).toEqual(world(new Array(12).fill(1)));
    expect(mirror.numPieces).toBe(1);
  });

  it('starts from nothing with a full patch that has fewer vertices and slots', () => {
    const mirror = new SheetMirror();
    mirror.apply(frameOf(kKeyframe));
    mirror.apply(frameOf(kDelta));
    mirror.apply(create(FrameSchema, { ...frameOf(kKeyframe), sequence: 3n, tick: 10n, topologyVersion: 5 }));
    expect(mirror.numVertices).toBe(4);
    expect(state(mirror).triangles).toEqual([0, 1, 2, -1, -1, -1, 0, 2, 3]);
  });

  const good = () => frameOf(kDelta);
  const bytes = (...values: number[]) => new Uint8Array(Int32Array.from(values).buffer);
  const refused: [string, (frame: Frame) => void][] = [
    ['a gap in the sequence', (f) => (f.sequence = 3n)],
    ['a delta against another tick', (f) => (f.baseTick = 6n)],
    ['a patch against another topology', (f) => (f.topology!.baseVersion = 2)],
    ['another topology without a patch', (f) => (f.topology = undefined)],
    ['positions that end early', (f) => (f.positions = f.positions.subarray(0, -1))],
    ['positions that end late', (f) => (f.positions = new Uint8Array([...f.positions, 0]))],
    ['a coordinate below 0', (f) => (f.positions = new Uint8Array(15).fill(1))],
    ['a triangle of a vertex that is not there', (f) => (f.topology!.triangles = bytes(0, 2, 5, -1, -1, -1, 0, 4, 3))],
    ['a triangle that is half empty', (f) => (f.topology!.triangles = bytes(0, 2, -1, -1, -1, -1, 0, 4, 3))],
    ['slots out of order', (f) => (f.topology!.slots = bytes(1, 3, 2))],
    ['a slot out of range', (f) => (f.topology!.slots = bytes(1, 2, 4))],
    ['fewer triangles than slots', (f) => (f.topology!.triangles = bytes(0, 2, 4))],
    ['a new vertex that is not listed', (f) => (f.topology!.vertices = bytes(2, 3))],
    ['fewer material positions than vertices', (f) => (f.topology!.materialPositions = new Uint8Array(8))],
    ['vertices that vanish', (f) => (f.numVertices = 3)],
    ['a keyframe without a box', (f) => Object.assign(f, { baseTick: -1n, positions: new Uint8Array(30) })],
  ];
  it.each(refused)('refuses %s and stays as it was', (_, spoil) => {
    const mirror = new SheetMirror();
    mirror.apply(frameOf(kKeyframe));
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
    mirror.apply(frameOf(kKeyframe));
    const before = state(mirror);
    mirror.apply(good());
    expect(mirror.numVertices).toBe(5);
    mirror.apply(create(FrameSchema, { ...frameOf(kKeyframe), sequence: 3n, tick: 9n, topologyVersion: 6 }));
    expect(state(mirror)).toEqual({ ...before, tick: 9, topologyVersion: 6 });
    const again = good();
    Object.assign(again, { sequence: 4n, tick: 10n, baseTick: 9n, topologyVersion: 7 });
    again.topology!.baseVersion = 6;
    mirror.apply(again);
    const twice = new SheetMirror();
    twice.apply(frameOf(kKeyframe));
    twice.apply(good());
    expect(state(mirror)).toEqual({ ...state(twice), tick: 10, topologyVersion: 7 });
  });

  it('refuses a delta as the first frame', () => {
    expect(() => new SheetMirror().apply(create(FrameSchema, { ...good(), sequence: 1n }))).toThrow(MirrorError);
  });
});

describe('addZigzagDeltas', () => {
  function encode(differences: number[]): Uint8Array {
    const bytes: number[] = [];
    for (const difference of differences) {
      let value = difference >= 0 ? 2 * difference : -2 * difference - 1;
      for (; value >= 0x80; value = Math.floor(value / 128)) bytes.push((value % 128) | 0x80);
      bytes.push(value);
    }
    return Uint8Array.from(bytes);
  }

  it('gives back every size of difference, of both signs', () => {
    const sizes = [0, 1, 63, 64, 8191, 8192, 32767, 65534, 65535];
    const base = Uint16Array.from(sizes.flatMap((size) => [0, size]));
    const out = new Uint16Array(base.length);
    addZigzagDeltas(encode(sizes.flatMap((size) => [size, -size])), base, base.length, out, base.length);
    expect([...out]).toEqual(sizes.flatMap((size) => [size, 0]));
  });

  it('refuses differences of four bytes and bytes that end inside one', () => {
    const out = new Uint16Array(1);
    expect(() => addZigzagDeltas(Uint8Array.of(0x80, 0x80, 0x80, 0), out, 1, out, 1)).toThrow('longer than 3 bytes');
    expect(() => addZigzagDeltas(Uint8Array.of(0x80, 0x80), out, 1, out, 1)).toThrow('end within');
    expect(() => addZigzagDeltas(Uint8Array.of(), out, 1, out, 1)).toThrow('end within');
    expect(() => addZigzagDeltas(encode([65536]), out, 1, out, 1)).toThrow('leaves 0..65535');
  });
});
