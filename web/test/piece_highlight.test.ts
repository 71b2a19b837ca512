import { BufferAttribute } from 'three';
import { describe, expect, it } from 'vitest';
import { PieceHighlight, pieceCentre, trianglesOf } from '../src/scene/piece_highlight';
import type { SheetArrays } from '../src/stream/sheet_copy';

// Two triangles of piece 0, one of piece 1, and a slot without material.
const kMirror = {
  numSlots: 4,
  triangles: Int32Array.from([0, 1, 2, -1, -1, -1, 1, 3, 2, 4, 5, 6]),
  pieces: Int32Array.from([0, 0, 0, 1]),
  positions: Float32Array.from([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 5, 0, 0, 6, 0, 0, 7, 0, 3]),
  topologyVersion: 1,
} as unknown as SheetArrays;

describe('trianglesOf', () => {
  it('has the corners of the piece alone', () => {
    expect([...trianglesOf(kMirror, 0)]).toEqual([0, 1, 2, 1, 3, 2]);
    expect([...trianglesOf(kMirror, 1)]).toEqual([4, 5, 6]);
  });
});

describe('pieceCentre', () => {
  it('is the mean of the corners', () => {
    expect(pieceCentre(kMirror, 1).toArray()).toEqual([6, 0, 1]);
  });
});

describe('PieceHighlight', () => {
  it('shows the piece that is set, of the mesh as it is now, and nothing without one', () => {
    const highlight = new PieceHighlight();
    const positions = new BufferAttribute(kMirror.positions, 3);
    highlight.update(kMirror, positions);
    expect(highlight.object.visible).toBe(false);
    highlight.set(0);
    highlight.update(kMirror, positions);
    expect(highlight.object.geometry.getIndex()!.count).toBe(6);
    highlight.update({ ...kMirror, topologyVersion: 2, pieces: Int32Array.from([1, 0, 0, 1]) }, positions);
    expect([...highlight.object.geometry.getIndex()!.array]).toEqual([1, 3, 2]);
    highlight.set(undefined);
    highlight.update(kMirror, positions);
    expect(highlight.object.visible).toBe(false);
  });
});
