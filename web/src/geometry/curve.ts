import type { Point2 } from './locator';

/**
 * Returns the point at t in 0..1 of the Bezier curve with these control points, of any degree. It is rational if the
 * weights (> 0, one per point) differ. De Casteljau's algorithm on (w x, w y, w).
 */
export function bezierPoint(points: readonly Point2[], t: number, weights?: readonly number[]): Point2 {
  const row = points.map(({ x, y }, i) => {
    const w = weights?.[i] ?? 1;
    return [w * x, w * y, w];
  });
  for (let length = row.length - 1; length > 0; --length) {
    for (let i = 0; i < length; ++i) row[i] = row[i].map((value, k) => (1 - t) * value + t * row[i + 1][k]);
  }
  const [x, y, w] = row[0];
  return { x: x / w, y: y / w };
}

/** The closeness with which polylines follow a curve. */
export interface Flatness {
  /** Largest distance between polyline and curve, in the curve's unit. */
  tolerance: number;
  /** Largest number of times that a curve is halved, >= 0. */
  depth: number;
}

// Share of the tolerance allowed at the three measured points of a chord, because the curve may be farther away between
// them.
const kMeasured = 0.9;
// A curve is halved at least this often, because one that turns back may look straight.
const kLeastDepth = 2;

/**
 * Returns points of a curve, both ends included, whose polyline follows the curve closely.
 * @param at  point of the curve at t in 0..1
 */
export function flattened(at: (t: number) => Point2, { tolerance, depth }: Flatness): Point2[] {
  const points = [at(0)];
  const add = (t0: number, t1: number, end: Point2, halvings: number): void => {
    const start = points[points.length - 1];
    const isDeep = halvings >= Math.min(kLeastDepth, depth);
    const isFlat = [0.25, 0.5, 0.75].every((part) => {
      return distanceToSegment(at(t0 + part * (t1 - t0)), start, end) <= kMeasured * tolerance;
    });
    if (halvings >= depth || (isDeep && isFlat)) {
      points.push(end);
      return;
    }
    const middle = 0.5 * (t0 + t1);
    add(t0, middle, at(middle), halvings + 1);
    add(middle, t1, end, halvings + 1);
  };
  add(0, 1, at(1), 0);
  return points;
}

/** Returns a closed polyline of n chords along an ellipse with centre c. The semi-axes end at a and b. */
export function ellipsePoints(c: Point2, a: Point2, b: Point2, n: number): Point2[] {
  return Array.from({ length: n + 1 }, (_, i) => {
    const angle = (2 * Math.PI * (i % n)) / n;
    const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
    return {
      x: c.x + cosine * (a.x - c.x) + sine * (b.x - c.x),
      y: c.y + cosine * (a.y - c.y) + sine * (b.y - c.y),
    };
  });
}

/**
 * Returns the fewest of the points, ends included, whose polyline stays within `tolerance` of all of them. Method:
 * Douglas and Peucker, "Algorithms for the reduction of the number of points required to represent a digitized line". A
 * drawn stroke has a point for each move of the hand, and a cut would put a vertex on each of them.
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

export function distance(a: Point2, b: Point2): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}

function distanceToSegment(p: Point2, a: Point2, b: Point2): number {
  const [dx, dy] = [b.x - a.x, b.y - a.y];
  const t = Math.min(1, Math.max(0, ((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}
