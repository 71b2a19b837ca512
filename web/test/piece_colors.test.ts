import { describe, expect, it, vi } from 'vitest';
import { carriedColors, pieceColor, pieceColors } from '../src/scene/piece_colors';
import { SheetMirror } from '../src/stream/mirror';
import { PieceIds } from '../src/stream/piece_ids';
import type { PieceList } from '../src/stream/piece_ids';

/** Two triangles that share no vertex, of pieces 0 and 1, and an empty slot. */
function twoPieces(): SheetMirror {
  const mirror = new SheetMirror();
  mirror.numVertices = 6;
  mirror.numSlots = 3;
  mirror.triangles = Int32Array.of(0, 1, 2, -1, -1, -1, 3, 4, 5);
  mirror.pieces = Int32Array.of(0, -1, 1);
  return mirror;
}

const list = (topologyVersion: number, ...ids: [number, number][]): PieceList => ({
  topologyVersion,
  ids: new Map(ids),
});

describe('pieceColor', () => {
  it('is another one for each of 21 ids in a row', () => {
    const colors = Array.from({ length: 21 }, (_, i) => pieceColor(i + 1).getHex());
    expect(new Set(colors).size).toBe(21);
    expect(pieceColor(22).getHex()).toBe(colors[0]);
  });
});

describe('pieceColors', () => {
  const rgb = (colors: Float32Array, vertex: number) => [...colors.subarray(3 * vertex, 3 * vertex + 3)];

  it('follow the id, whatever the label is', () => {
    const mirror = twoPieces();
    const before = pieceColors(mirror, new Map([[0, 4], [1, 9]]));
    mirror.pieces = Int32Array.of(1, -1, 0);
    const after = pieceColors(mirror, new Map([[0, 9], [1, 4]]));
    expect(after).toEqual(before);
    expect(rgb(before, 0)).toEqual(rgb(before, 2));
    expect(rgb(before, 0)).not.toEqual(rgb(before, 3));
    expect(rgb(before, 0)[0]).toBeCloseTo(pieceColor(4).r, 6);
  });

  it('are carried to new vertices while the ids are on their way', () => {
    const mirror = twoPieces();
    const old = pieceColors(mirror, new Map([[0, 1], [1, 2]]));
    mirror.numVertices = 10;
    mirror.numSlots = 5;
    // One beside the second piece, one that touches nothing known.
    mirror.triangles = Int32Array.of(0, 1, 2, -1, -1, -1, 3, 4, 5, 5, 4, 6, 7, 8, 9);
    const carried = carriedColors(mirror, old);
    expect(carried.subarray(0, 18)).toEqual(old);
    expect(rgb(carried, 6)).toEqual(rgb(old, 4));
    expect(rgb(carried, 7)[0]).toBe(rgb(carried, 7)[1]);
  });
});

describe('a vertex without material', () => {
  const ids = new Map([[0, 1], [1, 2]]);
  const rgb = (colors: Float32Array, vertex: number) => [...colors.subarray(3 * vertex, 3 * vertex + 3)];

  it('has no colour, and gets its neighbour\'s when its triangle is back', () => {
    const mirror = twoPieces();
    mirror.numSlots = 4;
    mirror.triangles = Int32Array.of(0, 1, 2, -1, -1, -1, -1, -1, -1, -1, -1, -1);
    mirror.pieces = Int32Array.of(0, -1, -1, -1);
    const cut = pieceColors(mirror, ids);
    expect(rgb(cut, 4)).toEqual([0, 0, 0]);
    mirror.triangles = Int32Array.of(0, 1, 2, 2, 1, 3, 3, 4, 5, -1, -1, -1);
    mirror.pieces = Int32Array.of(0, 0, 0, -1);
    const back = carriedColors(mirror, cut);
    expect(rgb(back, 3)).toEqual(rgb(cut, 0));
    for (const vertex of [4, 5]) expect(Math.max(...rgb(back, vertex))).toBeGreaterThan(0);
  });
});

describe('PieceIds', () => {
  it('asks once for each version, and gives what belongs to it', async () => {
    const arrived = vi.fn();
    const ask = vi.fn(async () => list(3, [0, 5]));
    const ids = new PieceIds(arrived, ask);
    expect(ids.at('sheets/a', 3)).toBeUndefined();
    expect(ids.at('sheets/a', 3)).toBeUndefined();
    await vi.waitFor(() => expect(arrived).toHaveBeenCalledTimes(1));
    expect(ids.at('sheets/a', 3)?.get(0)).toBe(5);
    expect(ask).toHaveBeenCalledTimes(1);
  });

  it('waits for the frame where the server is ahead, and asks again where it was behind', async () => {
    const arrived = vi.fn();
    const answers = [list(2, [0, 1]), list(5, [0, 7])];
    const ask = vi.fn(async () => answers.shift());
    const ids = new PieceIds(arrived, ask);
    ids.at('sheets/a', 4);
    await vi.waitFor(() => expect(arrived).toHaveBeenCalledTimes(1));
    expect(ids.at('sheets/a', 4)).toBeUndefined();
    await vi.waitFor(() => expect(arrived).toHaveBeenCalledTimes(2));
    expect(ids.at('sheets/a', 4)).toBeUndefined();
    expect(ids.at('sheets/a', 5)?.get(0)).toBe(7);
    expect(ask).toHaveBeenCalledTimes(2);
  });

  it('takes no answer from before versions began again', async () => {
    const answers: ((found: PieceList) => void)[] = [];
    const ids = new PieceIds(
      () => {},
      () => new Promise<PieceList>((resolve) => answers.push(resolve)),
    );
    ids.at('sheets/a', 2);
    ids.reset();
    ids.at('sheets/a', 2);
    answers[0](list(2, [0, 1]));
    await vi.waitFor(() => {
      ids.at('sheets/a', 2);
      expect(answers).toHaveLength(2);
    });
    answers[1](list(2, [0, 7]));
    await vi.waitFor(() => expect(ids.at('sheets/a', 2)?.get(0)).toBe(7));
  });

  it('takes no answer for another sheet, and asks again after a failure', async () => {
    vi.useFakeTimers();
    const arrived = vi.fn();
    let failures = 1;
    const ask = vi.fn(async (sheet: string) => {
      if (sheet === 'sheets/b' && failures-- > 0) throw new Error('gone');
      return sheet === 'sheets/a' ? list(1, [0, 1]) : list(1, [0, 2]);
    });
    const ids = new PieceIds(arrived, ask);
    ids.at('sheets/a', 1);
    ids.at('sheets/b', 1);
    await vi.advanceTimersByTimeAsync(0);
    expect(ids.at('sheets/b', 1)).toBeUndefined();
    await vi.advanceTimersByTimeAsync(2000);
    expect(ids.at('sheets/b', 1)).toBeUndefined();
    await vi.advanceTimersByTimeAsync(0);
    expect(ids.at('sheets/b', 1)?.get(0)).toBe(2);
    expect(ask.mock.calls.map(([sheet]) => sheet)).toEqual(['sheets/a', 'sheets/b', 'sheets/b']);
    vi.useRealTimers();
  });
});
