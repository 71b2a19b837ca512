import { describe, expect, it } from 'vitest';
import { pathLines, subpaths } from '../src/geometry/path_lines';

const noArcs = () => [];
const lines = (data: string, pieces = 1) =>
  pathLines(data, pieces, noArcs).map((line) => line.map(({ x, y }) => [x, y]));

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
    const [curve] = lines('M0 0C0 3 3 3 3 0S6-3 6 0', 2);
    expect(curve[1]).toEqual([1.5, 2.25]);
    expect(curve[3]).toEqual([4.5, -2.25]);
    const [parabola] = lines('M0 0q1 2 2 0t2 0', 2);
    expect(parabola).toEqual([[0, 0], [1, 1], [2, 0], [3, -1], [4, 0]]);
    // Nothing to mirror after another kind of segment.
    expect(lines('M0 0L2 0T4 0', 2)[0][2]).toEqual([2.5, 0]);
  });

  it('gives arcs away one by one, with their flags', () => {
    const asked: string[] = [];
    const result = pathLines('M1 2a3 3 0 0110 0 3 3 0 1 1-1 1', 4, (data) => {
      asked.push(data);
      return [{ x: 1, y: 2 }, { x: 11, y: 2 }];
    });
    expect(asked).toEqual(['M1 2a3 3 0 0 1 10 0', 'M11 2a3 3 0 1 1 -1 1']);
    expect(result[0]).toHaveLength(3);
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
