import { describe, expect, it } from 'vitest';
import { meshFile, sheetGeometry } from '../src/scene/mesh_file';
import { meshHash } from '../src/stream/mesh_hash';
import type { SheetArrays } from '../src/stream/sheet_copy';

// Two triangles of a square that stands upright, with an empty slot between them and room at the end of each array.
const kSheet: SheetArrays = {
  epoch: 'one',
  tick: 7,
  topologyVersion: 2,
  numVertices: 4,
  numSlots: 3,
  numPieces: 1,
  positions: Float32Array.of(0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1, 9, 9, 9),
  materialPositions: Float32Array.of(0, 0, 2, 0, 2, 2, 0, 2, 8, 8),
  triangles: Int32Array.of(0, 1, 2, -1, -1, -1, 0, 2, 3, 5, 5, 5),
  pieces: Int32Array.of(0, -1, 0, 4),
  strains: undefined,
  stats: undefined,
};

describe('sheetGeometry', () => {
  it('has the vertices by their numbers and the triangles that there are', () => {
    const geometry = sheetGeometry(kSheet);
    expect([...geometry.getIndex()!.array]).toEqual([0, 1, 2, 0, 2, 3]);
    expect([...geometry.getAttribute('position').array]).toEqual([0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1]);
    expect([...geometry.getAttribute('uv').array]).toEqual([0, 0, 2, 0, 2, 2, 0, 2]);
    expect([...geometry.getAttribute('normal').array.slice(0, 3)].map((value) => value + 0)).toEqual([0, -1, 0]);
  });
});

describe('meshFile', () => {
  it('writes an OBJ that says the same, in metres', async () => {
    const { content, mediaType } = await meshFile(kSheet, 'flag', 'obj');
    expect(mediaType).toBe('model/obj');
    const lines = (content as string).trim().split('\n');
    const of = (kind: string) => lines.filter((line) => line.startsWith(`${kind} `)).map((line) => line.slice(kind.length + 1));
    expect(of('o')).toEqual(['flag']);
    expect(of('v')).toEqual(['0 0 0', '1 0 0', '1 0 1', '0 0 1']);
    expect(of('vt')).toEqual(['0 0', '2 0', '2 2', '0 2']);
    expect(of('f').map((face) => face.replaceAll(/\/\S+/g, ''))).toEqual(['1 2 3', '1 3 4']);
  });
});

describe('meshHash', () => {
  it('changes with triangles, pieces and material positions, and with nothing else', () => {
    const hash = meshHash(kSheet);
    expect(hash).toMatch(/^[0-9a-f]{8}$/);
    const at = (changes: Partial<SheetArrays>) => meshHash({ ...kSheet, ...changes });
    expect(at({ positions: new Float32Array(12), tick: 99, topologyVersion: 5 })).toBe(hash);
    // Values in the spare room do not count.
    expect(at({ triangles: kSheet.triangles.slice(0, 9), pieces: kSheet.pieces.slice(0, 3) })).toBe(hash);
    expect(at({ triangles: Int32Array.of(1, 2, 0, -1, -1, -1, 0, 2, 3) })).not.toBe(hash);
    expect(at({ pieces: Int32Array.of(0, -1, 1) })).not.toBe(hash);
    expect(at({ materialPositions: Float32Array.of(0, 0, 2, 0, 2, 2, 0, 2.0001) })).not.toBe(hash);
    expect(at({ numSlots: 1 })).not.toBe(hash);
  });
});
