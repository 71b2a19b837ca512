import { describe, expect, it } from 'vitest';
import { pathLines, subpaths } from '../src/geometry/path_lines';

const lines = (data: string, depth = 0) =>
  pathLines(data, { tolerance: 1e-9, depth }).map((line) => line.map(({ x, y }) => [x, y]));

describe('pathLines', () => {
  it('reads lines, absolute and relative, and pairs after a move', () => {
    expect(lines('M1 1 2 3L4,4h-1V0')).toEqual([[[1, 1], [2, 3], [4, 4], [3, 4], [3, 0]]]);
    expect(lines('m1-1l.5.5 1e1-2')).toEqual([[[1, -1], [1.5, -0.5], [11.5, -2.5]]]);
  });

  it('begins subpaths at moves and, after a close, at the start', () => {
    expect(lines('M1 1h2v2zm5 0h1')).toEqual([[[1, 1], [3, 1], [3, 3], [1, 1]], [[6, 1], [7, 1]]]);
    expect(lines('M1 1h2zv4')).toEqual([[[1, 1], [3, 1], [1, 1]], [[1, 1], [1, 5]]]);
  });

  it('reads curves and mirrors their control points', () => {
    const [curve] = lines('M0 0C0 3 3 3 3 0S6-3 6 0', 1);
    expect(curve[1]).toEqual([1.5, 2.25]);
    expect(curve[3]).toEqual([4.5, -2.25]);
    const [parabola] = lines('M0 0q1 2 2 0t2 0', 1);
    expect(parabola).toEqual([[0, 0], [1, 1], [2, 0], [3, -1], [4, 0]]);
    // Nothing to mirror after another kind of segment.
    expect(lines('M0 0L2 0T4 0', 1)[0][2]).toEqual([2.5, 0]);
  });

  it('follows arcs one by one, whose flags may stand together', () => {
    const [line] = lines('M1 2a5 5 0 0110 0 5 5 0 0 1-10 0', 3);
    expect(line).toHaveLength(17);
    for (const [x, y] of line) expect(Math.hypot(x - 6, y - 2)).toBeCloseTo(5, 12);
    expect([line[0], line[8], line[16]]).toEqual([[1, 2], [11, 2], [1, 2]]);
    // Down is the positive y of path data: turning with it, the first half goes over the top.
    expect(line[4][1]).toBeCloseTo(-3, 12);
    expect(lines('M0 0A0 5 0 0 1 3 3a2 2 0 0 0 0 0', 3)).toEqual([[[0, 0], [3, 3], [3, 3]]]);
  });

  it('has as many chords as the tolerance asks for, and few where it is straight', () => {
    const circle = 'M1 0A1 1 0 0 1-1 0A1 1 0 0 1 1 0z';
    for (const tolerance of [1e-2, 1e-3, 1e-4]) {
      const [line] = pathLines(circle, { tolerance, depth: 9 });
      const sagittas = line.slice(1).map((end, i) => 1 - Math.hypot(0.5 * (line[i].x + end.x), 0.5 * (line[i].y + end.y)));
      expect(Math.max(...sagittas)).toBeLessThanOrEqual(tolerance);
      expect(Math.max(...sagittas)).toBeGreaterThan(tolerance / 5);
    }
    expect(pathLines('M0 0C1 1 2 2 3 3', { tolerance: 1e-3, depth: 9 })[0]).toHaveLength(5);
  });

  it('ends at what it cannot read', () => {
    expect(lines('M0 0L1 1L2')).toEqual([[[0, 0], [1, 1]]]);
    expect(lines('nothing')).toEqual([]);
  });
});

describe('subpaths', () => {
  it('gives each where it was, whatever those before it were made of', () => {
    expect(subpaths('m1 1h4v4zm2 2 1 0 0 1z')).toEqual(['M1 1h4v4z', 'M3 3l1 0l0 1z']);
    expect(subpaths('M0 0C1 1 2 2 3 3q1 1 2 0a3 3 0 0110 0m1 1H0V0')).toEqual([
      'M0 0C1 1 2 2 3 3q1 1 2 0a3 3 0 0 1 10 0',
      'M16 4H0V0',
    ]);
  });

  it('begins one at the start after a close, as pathLines does', () => {
    const data = 'M1 1h2v2zv4h1Z l3 3';
    expect(subpaths(data)).toEqual(['M1 1h2v2z', 'M1 1v4h1Z', 'M1 1l3 3']);
    expect(subpaths(data).flatMap((part) => lines(part))).toEqual(lines(data));
  });

  it('leaves out moves without a line', () => {
    expect(subpaths('M1 1M2 2L3 3M4 4')).toEqual(['M2 2L3 3']);
    expect(subpaths('')).toEqual([]);
  });
});
