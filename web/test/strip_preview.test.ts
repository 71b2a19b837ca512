import { describe, expect, it } from 'vitest';
import type { Point2 } from '../src/geometry/locator';
import { stripPolygons } from '../src/geometry/strip';
import { stripAlong } from '../src/tools/strip_preview';

/** A square with this lower left corner, as a closed line. */
function square(x: number, y: number, side: number): Point2[] {
  return [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]].map(([dx, dy]) => ({ x: x + dx * side, y: y + dy * side }));
}

function ring(numChords: number): Point2[] {
  return Array.from({ length: numChords + 1 }, (_, i) => {
    const angle = (2 * Math.PI * (i % numChords)) / numChords;
    return { x: Math.cos(angle), y: Math.sin(angle) };
  });
}

/** True if one of these convex polygons, which turn counter-clockwise, has the point in it. */
function covers(polygons: readonly (readonly Point2[])[], { x, y }: Point2): boolean {
  return polygons.some((polygon) =>
    polygon.every((a, i) => {
      const b = polygon[(i + 1) % polygon.length];
      return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x) >= -1e-12;
    }),
  );
}

describe('stripAlong', () => {
  it('follows a drawing of few chords exactly, and takes nothing without a width', () => {
    const line = ring(400);
    expect(stripAlong([line], 0.1, [])).toEqual(stripPolygons(line, 0.1));
    expect(stripAlong([line], 0, [])).toEqual([]);
  });

  it('simplifies a line of many chords, and covers all of it', () => {
    const line = ring(9000);
    const strip = stripAlong([line], 0.1, []);
    expect(strip.length).toBeLessThan(500);
    for (let i = 0; i < line.length; i += 7) expect(covers(strip, line[i]), `point ${i}`).toBe(true);
  });

  it('keeps each of many small shapes whole', () => {
    const squares = Array.from({ length: 1600 }, (_, i) => square(i % 40, Math.floor(i / 40), 0.5));
    const strip = stripAlong(squares, 0.05, []);
    const perSquare = strip.length / squares.length;
    squares.forEach((corners, i) => {
      const own = strip.slice(i * perSquare, (i + 1) * perSquare);
      for (const corner of corners) expect(covers(own, corner), `square ${i}`).toBe(true);
      expect(covers(own, { x: corners[0].x + 0.25, y: corners[0].y + 0.25 })).toBe(false);
    });
  });

  it('leaves out between dashes what is left, however many chords there are', () => {
    const along = Array.from({ length: 5001 }, (_, i) => ({ x: i / 5000, y: 0 }));
    const strip = stripAlong([along], 0.01, [0.3, 0.2]);
    const isTaken = [0.1, 0.29, 0.4, 0.6, 0.79, 0.9].map((x) => covers(strip, { x, y: 0 }));
    expect(isTaken).toEqual([true, true, false, true, true, false]);
  });
});
