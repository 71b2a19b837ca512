import { describe, expect, it } from 'vitest';
import type { Point2 } from '../src/geometry/locator';
import { dashes, stripPolygons } from '../src/geometry/strip';

const at = (x: number, y: number): Point2 => ({ x, y });

function signedArea(polygon: readonly Point2[]): number {
  return 0.5 * polygon.reduce((sum, a, i) => {
    const b = polygon[(i + 1) % polygon.length];
    return sum + a.x * b.y - a.y * b.x;
  }, 0);
}

function contains(polygon: readonly Point2[], { x, y }: Point2): boolean {
  return polygon.every((a, i) => {
    const b = polygon[(i + 1) % polygon.length];
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x) >= -1e-12;
  });
}

function distanceTo(line: readonly Point2[], p: Point2): number {
  return Math.min(
    ...line.slice(1).map((b, i) => {
      const a = line[i];
      const [dx, dy] = [b.x - a.x, b.y - a.y];
      const t = Math.min(1, Math.max(0, ((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy)));
      return Math.hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
    }),
  );
}

describe('stripPolygons', () => {
  const bend = [at(0, 0), at(1, 0), at(1.4, 0.1), at(1.7, 0.3), at(1, 0.5), at(1, 0.5), at(0, 1)];
  const ring = Array.from({ length: 65 }, (_, i) => at(Math.cos((i % 64) / 32 * Math.PI), Math.sin((i % 64) / 32 * Math.PI)));

  it.each([
    ['an open line with soft and sharp bends both ways, one point doubled', bend],
    ['a ring', ring],
  ])('cover what a disc on %s sweeps, and no more', (_, line) => {
    const polygons = stripPolygons(line, 0.2);
    expect(Math.min(...polygons.map(signedArea))).toBeGreaterThanOrEqual(0);
    for (let i = 0; i < 60; ++i) {
      for (let j = 0; j < 60; ++j) {
        const p = at(-1.3 + 0.052 * i, -1.3 + 0.052 * j);
        const distance = distanceTo(line, p);
        const isCovered = polygons.some((polygon) => contains(polygon, p));
        // A disc of 16 sides lacks 2 % of its radius.
        if (distance < 0.097) expect(isCovered, `${p.x} ${p.y} at ${distance}`).toBe(true);
        if (distance > 0.1001) expect(isCovered, `${p.x} ${p.y} at ${distance}`).toBe(false);
      }
    }
  });

  it('are a disc for a point, and none for nothing', () => {
    expect(stripPolygons([at(1, 1), at(1, 1)], 0.5).every((polygon) => contains(polygon, at(1, 1)))).toBe(true);
    expect(stripPolygons([], 0.5)).toEqual([]);
  });
});

describe('dashes', () => {
  it('go on round corners and begin anew on each line', () => {
    const lines = [
      [at(0, 0), at(2, 0), at(2, 2)],
      [at(5, 0), at(5.5, 0)],
    ];
    expect(dashes(lines, [1.5, 0.25])).toEqual([
      [at(0, 0), at(1.5, 0)],
      [at(1.75, 0), at(2, 0), at(2, 1.25)],
      [at(2, 1.5), at(2, 2)],
      [at(5, 0), at(5.5, 0)],
    ]);
  });

  it('end where the line ends in what is left out', () => {
    expect(dashes([[at(0, 0), at(1.2, 0)]], [1, 0.5])).toEqual([[at(0, 0), at(1, 0)]]);
    expect(dashes([[at(0, 0), at(1, 0)]], [])).toEqual([[at(0, 0), at(1, 0)]]);
  });
});
