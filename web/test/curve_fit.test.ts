import { describe, expect, it } from 'vitest';
import { bezierPoint, distance } from '../src/geometry/curve';
import { cornersOf, fitCurve } from '../src/geometry/curve_fit';
import type { Cubic } from '../src/geometry/curve_fit';
import type { Point2 } from '../src/geometry/locator';

const kTolerance = 1.5;

// Numbers in -1..1 that are always the same.
function trembler(): () => number {
  let seed = 12345;
  return () => {
    seed = (seed * 1103515245 + 12345) % 2147483648;
    return seed / 1073741824 - 1;
  };
}

function sampled(pieces: readonly Cubic[]): Point2[] {
  return pieces.flatMap((piece) => Array.from({ length: 200 }, (_, i) => bezierPoint(piece, i / 199)));
}

function distanceTo(curve: readonly Point2[], point: Point2): number {
  return Math.min(...curve.map((at) => distance(at, point)));
}

// Largest distance of the drawn points from the curve. Samples of the curve are up to 0.05 apart from it.
function error(points: readonly Point2[], pieces: readonly Cubic[]): number {
  const curve = sampled(pieces);
  return Math.max(...points.map((point) => distanceTo(curve, point)));
}

// Largest turn between neighbouring pieces, degrees.
function kinks(pieces: readonly Cubic[]): number[] {
  const turn = ([, , a, b]: Cubic, [c, d]: Cubic) => {
    const angle = Math.atan2(d.y - c.y, d.x - c.x) - Math.atan2(b.y - a.y, b.x - a.x);
    return Math.abs(Math.atan2(Math.sin(angle), Math.cos(angle))) * (180 / Math.PI);
  };
  return pieces.slice(1).map((piece, i) => turn(pieces[i], piece));
}

const circle = (count: number, radius: number, tremble = () => 0): Point2[] => {
  const points = Array.from({ length: count }, (_, i) => ({
    x: 300 + radius * Math.cos((2 * Math.PI * i) / count) + tremble(),
    y: 300 + radius * Math.sin((2 * Math.PI * i) / count) + tremble(),
  }));
  return [...points, points[0]];
};

describe('fitCurve', () => {
  it('makes one piece of a straight stroke', () => {
    const points = Array.from({ length: 40 }, (_, i) => ({ x: 10 * i, y: 5 * i }));
    const pieces = fitCurve(points, kTolerance);
    expect(pieces).toHaveLength(1);
    expect([pieces[0][0], pieces[0][3]]).toEqual([points[0], points[39]]);
    expect(error(points, pieces)).toBeLessThan(1.2);
  });

  it('makes a smooth circle of 24 places of the mouse, where straight lines have corners', () => {
    const points = circle(24, 100);
    const pieces = fitCurve(points, kTolerance);
    expect(error(points, pieces)).toBeLessThan(kTolerance + 0.5);
    expect(pieces.length).toBeLessThan(9);
    expect(Math.max(...kinks([...pieces, pieces[0]]))).toBeLessThan(0.01);
    // Between the places of the mouse it is the circle, too.
    for (const { x, y } of sampled(pieces)) expect(Math.abs(Math.hypot(x - 300, y - 300) - 100)).toBeLessThan(kTolerance + 0.5);
  });

  it('stays within the tolerance of a trembling hand, and does not follow its tremor', () => {
    const tremble = trembler();
    const points = circle(300, 120, () => 0.7 * tremble());
    const pieces = fitCurve(points, kTolerance);
    expect(error(points, pieces)).toBeLessThan(kTolerance + 0.1);
    expect(pieces.length).toBeLessThan(16);
  });

  it('keeps the corners that were drawn', () => {
    const side = (from: Point2, to: Point2) =>
      Array.from({ length: 20 }, (_, i) => ({ x: from.x + ((to.x - from.x) * i) / 20, y: from.y + ((to.y - from.y) * i) / 20 }));
    const corners = [{ x: 0, y: 0 }, { x: 200, y: 0 }, { x: 200, y: 150 }, { x: 40, y: 150 }];
    const points = [...corners.flatMap((from, i) => side(from, corners[(i + 1) % 4])), corners[0]];
    const pieces = fitCurve(points, kTolerance);
    expect(pieces.map(([start]) => start)).toEqual(corners);
    expect(kinks(pieces).every((turn) => turn > 60)).toBe(true);
    expect(error(points, pieces)).toBeLessThan(1);
  });

  it('bounds the error of strokes of every kind', () => {
    const tremble = trembler();
    for (let trial = 0; trial < 20; ++trial) {
      let [x, y, heading] = [0, 0, 0];
      const step = 2 + 10 * Math.abs(tremble());
      const points = Array.from({ length: 120 }, () => {
        heading += 0.35 * tremble() + (Math.abs(tremble()) > 0.97 ? 2 : 0);
        [x, y] = [x + step * Math.cos(heading), y + step * Math.sin(heading)];
        return { x, y };
      });
      const pieces = fitCurve(points, kTolerance);
      expect(error(points, pieces), `trial ${trial}`).toBeLessThan(kTolerance + 0.1);
      pieces.slice(1).forEach(([start], i) => expect(start).toEqual(pieces[i][3]));
      expect(pieces.length).toBeLessThan(points.length - 1);
    }
  });

  it('takes two points, and points that repeat', () => {
    const [a, b] = [{ x: 1, y: 1 }, { x: 4, y: 5 }];
    expect(fitCurve([a, a, b, b], kTolerance)).toHaveLength(1);
    expect(fitCurve([a, a], kTolerance)).toEqual([]);
    expect(fitCurve([], kTolerance)).toEqual([]);
  });
});

describe('cornersOf', () => {
  it('finds a corner once, whatever the distance of the points', () => {
    for (const step of [1, 4, 30]) {
      const count = Math.floor(120 / step);
      const points = Array.from({ length: 2 * count + 1 }, (_, i) => ({ x: step * Math.min(i, count), y: step * Math.max(0, i - count) }));
      const found = cornersOf(points, 9).flatMap((isCorner, i) => (isCorner ? [i] : []));
      expect(found, `step ${step}`).toEqual([count]);
    }
  });

  it('finds none on a circle of 10 pixels', () => {
    expect(cornersOf(circle(40, 10), 9).some((isCorner) => isCorner)).toBe(false);
  });
});
