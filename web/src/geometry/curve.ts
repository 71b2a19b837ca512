import type { Point2 } from './locator';

/** Point of the cubic Bezier curve with the given four control points at t in 0..1. */
export function bezierPoint(p: readonly Point2[], t: number): Point2 {
  const s = 1 - t;
  const [a, b, c, d] = [s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t];
  return {
    x: a * p[0].x + b * p[1].x + c * p[2].x + d * p[3].x,
    y: a * p[0].y + b * p[1].y + c * p[2].y + d * p[3].y,
  };
}

/**
 * The fewest of the given points, ends included, whose polyline stays within `tolerance` of all of them (Douglas and
 * Peucker, "Algorithms for the reduction of the number of points required to represent a digitized line", 1973). A
 * stroke has a point for each move of the hand, and a cut puts a vertex on each point of its polyline.
 */
export function simplify(points: readonly Point2[], tolerance: number): Point2[] {
  const isKept = points.map((_, i) => i === 0 || i === points.length - 1);
  const spans: [number, number][] = [[0, points.length - 1]];
  for (let span = spans.pop(); span; span = spans.pop()) {
    const [first, last] = span;
    let farthest = -1;
    let largest = tolerance;
    for (let i = first + 1; i < last; ++i) {
      const distance = distanceToSegment(points[i], points[first], points[last]);
      if (distance > largest) [farthest, largest] = [i, distance];
    }
    if (farthest < 0) continue;
    isKept[farthest] = true;
    spans.push([first, farthest], [farthest, last]);
  }
  return points.filter((_, i) => isKept[i]);
}

function distanceToSegment(p: Point2, a: Point2, b: Point2): number {
  const [dx, dy] = [b.x - a.x, b.y - a.y];
  const t = Math.min(1, Math.max(0, ((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}
