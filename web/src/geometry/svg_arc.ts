import type { Point2 } from './locator';

/** An arc of path data without its end: radii, rotation of the x axis in degrees, flags. */
export type ArcNumbers = readonly [rx: number, ry: number, turnDeg: number, isLarge: number, isSweep: number];

/**
 * Returns a function that gives the point at t in 0..1 of an elliptical arc (SVG 1.1, F.6). Undefined if the arc is
 * straight or empty: a radius is 0, or its ends are equal.
 */
export function svgArc(from: Point2, to: Point2, [rx, ry, turnDeg, isLarge, isSweep]: ArcNumbers) {
  if (rx === 0 || ry === 0 || (from.x === to.x && from.y === to.y)) return undefined;
  const turn = (turnDeg * Math.PI) / 180;
  const [cosine, sine] = [Math.cos(turn), Math.sin(turn)];
  // Half of the vector from the end back to the start, along the axes of the ellipse.
  const [halfX, halfY] = [0.5 * (from.x - to.x), 0.5 * (from.y - to.y)];
  const x = cosine * halfX + sine * halfY;
  const y = -sine * halfX + cosine * halfY;
  const reach = Math.hypot(x / rx, y / ry);
  // Radii that are too short are stretched until the ellipse reaches both ends.
  const [a, b] = [Math.abs(rx), Math.abs(ry)].map((radius) => radius * Math.max(1, reach));
  const offset = Math.sqrt(Math.max(0, 1 / Math.hypot(x / a, y / b) ** 2 - 1)) * (isLarge === isSweep ? -1 : 1);
  const [centerX, centerY] = [(offset * a * y) / b, (-offset * b * x) / a];
  const start = Math.atan2((y - centerY) / b, (x - centerX) / a);
  const end = Math.atan2((-y - centerY) / b, (-x - centerX) / a);
  const whole = 2 * Math.PI;
  // The arc sweeps less than a whole turn, in the negative direction without the sweep flag.
  const swept = isSweep ? (end - start + 2 * whole) % whole : -((start - end + 2 * whole) % whole);
  const [middleX, middleY] = [0.5 * (from.x + to.x), 0.5 * (from.y + to.y)];
  return (t: number): Point2 => {
    const angle = start + t * swept;
    const [u, v] = [centerX + a * Math.cos(angle), centerY + b * Math.sin(angle)];
    return { x: middleX + cosine * u - sine * v, y: middleY + sine * u + cosine * v };
  };
}
