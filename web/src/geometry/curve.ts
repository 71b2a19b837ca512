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

/** A polyline with equally spaced points, `spacing` apart (the last piece may be shorter). */
export function resample(points: readonly Point2[], spacing: number): Point2[] {
  const result: Point2[] = [{ ...points[0] }];
  let last = result[0];
  for (const point of points.slice(1)) {
    for (let distance = Math.hypot(point.x - last.x, point.y - last.y); distance >= spacing; distance -= spacing) {
      const t = spacing / distance;
      last = { x: last.x + t * (point.x - last.x), y: last.y + t * (point.y - last.y) };
      result.push(last);
    }
  }
  const end = points[points.length - 1];
  if (Math.hypot(end.x - last.x, end.y - last.y) > 0.25 * spacing) result.push({ ...end });
  return result;
}
