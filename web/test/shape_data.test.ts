import { describe, expect, it } from 'vitest';
import { pathLines } from '../src/geometry/path_lines';
import { ellipseData, linesData, rectangleData, shapeData } from '../src/geometry/shape_data';
import { svgArc } from '../src/geometry/svg_arc';

const kFine = { tolerance: 1e-4, depth: 9 };

/** A shape as the browser has it. */
function shape(localName: string, lengths: Record<string, number>, other: object = {}): SVGGeometryElement {
  const animated = Object.entries(lengths).map(([name, value]) => [name, { baseVal: { value } }]);
  const hasAttribute = (name: string) => lengths[name] !== undefined && lengths[name] !== 0;
  return { localName, hasAttribute, ...Object.fromEntries(animated), ...other } as unknown as SVGGeometryElement;
}

describe('shapeData', () => {
  it('rounds the corners of a rectangle by arcs between its straight sides', () => {
    const [line] = pathLines(rectangleData(10, 20, 40, 30, 5, 5), kFine);
    expect(line[0]).toEqual({ x: 15, y: 20 });
    expect(line[1]).toEqual({ x: 45, y: 20 });
    for (const { x, y } of line) {
      const [dx, dy] = [Math.abs(x - 30) - 15, Math.abs(y - 35) - 10];
      // On a side, or on the circle of a corner.
      if (dx > 0 && dy > 0) expect(Math.hypot(dx, dy)).toBeCloseTo(5, 9);
      else expect(Math.min(Math.abs(dx - 5), Math.abs(dy - 5))).toBeLessThan(1e-9);
    }
    expect(line.filter(({ x, y }) => x > 45 && y < 25).length).toBeGreaterThan(20);
  });

  it('takes the one radius for the other, and no more than half a side', () => {
    const rounded = shape('rect', { x: 0, y: 0, width: 4, height: 2, rx: 0.5, ry: 0 });
    expect(shapeData(rounded)).toBe(rectangleData(0, 0, 4, 2, 0.5, 0.5));
    expect(rectangleData(0, 0, 4, 2, 9, 9)).toBe(rectangleData(0, 0, 4, 2, 2, 1));
    expect(shapeData(shape('rect', { x: 1, y: 2, width: 3, height: 4, rx: 0, ry: 0 }))).toBe('M1 2h3v4h-3z');
    expect(rectangleData(0, 0, 0, 2, 0, 0)).toBe('');
  });

  it('makes circles and ellipses of two arcs, closed', () => {
    expect(shapeData(shape('circle', { cx: 1, cy: 2, r: 3 }))).toBe(ellipseData(1, 2, 3, 3));
    const [line] = pathLines(shapeData(shape('ellipse', { cx: 1, cy: 2, rx: 3, ry: 1 })), kFine);
    for (const { x, y } of line) expect(((x - 1) / 3) ** 2 + (y - 2) ** 2).toBeCloseTo(1, 9);
    expect(line.at(-1)).toEqual(line[0]);
    expect(ellipseData(0, 0, 1, 0)).toBe('');
  });

  it('joins points by lines', () => {
    const corners = [{ x: 0, y: 0 }, { x: 1, y: 0 }, { x: 1, y: 1 }];
    const points = { numberOfItems: 3, getItem: (i: number) => corners[i] };
    expect(shapeData(shape('polyline', {}, { points }))).toBe('M0 0L1 0L1 1');
    expect(shapeData(shape('polygon', {}, { points }))).toBe('M0 0L1 0L1 1z');
    expect(shapeData(shape('line', { x1: 1, y1: 2, x2: 3, y2: 4 }))).toBe('M1 2L3 4');
    expect(linesData([{ x: 1, y: 1 }], true)).toBe('');
  });

  it('leaves paths as they are', () => {
    expect(shapeData(shape('path', {}, { getAttribute: () => 'M0 0h1' }))).toBe('M0 0h1');
  });
});

describe('svgArc', () => {
  const [from, to] = [{ x: 0, y: 0 }, { x: 1, y: 1 }];

  it.each([
    [0, 0],
    [0, 1],
    [1, 0],
    [1, 1],
  ])('is the arc of its flags, large %i, sweep %i, from end to end', (isLarge, isSweep) => {
    const arc = svgArc(from, to, [2, 1, 30, isLarge, isSweep])!;
    for (const [t, end] of [[0, from], [1, to]] as const) {
      expect(arc(t).x).toBeCloseTo(end.x, 12);
      expect(arc(t).y).toBeCloseTo(end.y, 12);
    }
    // The area between arc and chord is positive where it turns with the y axis down, and larger of large arcs.
    let area = 0;
    let length = 0;
    for (let i = 0; i < 1000; ++i) {
      const [a, b] = [arc(i / 1000), arc((i + 1) / 1000)];
      area += 0.5 * (a.x * b.y - a.y * b.x);
      length += Math.hypot(b.x - a.x, b.y - a.y);
    }
    expect(Math.sign(area)).toBe(isSweep ? 1 : -1);
    expect(length > 4.84).toBe(isLarge === 1);
  });

  it('stretches radii that do not reach its ends', () => {
    const arc = svgArc(from, { x: 4, y: 0 }, [1, 1, 0, 0, 1])!;
    expect(arc(0.5).x).toBeCloseTo(2, 12);
    expect(arc(0.5).y).toBeCloseTo(-2, 12);
  });

  it('is a straight line without a radius or a way', () => {
    expect(svgArc(from, to, [0, 1, 0, 0, 1])).toBeUndefined();
    expect(svgArc(from, from, [1, 1, 0, 1, 1])).toBeUndefined();
  });
});
