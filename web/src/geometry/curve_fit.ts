import { bezierPoint, distance } from './curve';
import type { Point2 } from './locator';

/** Control points of a cubic Bezier piece. */
export type Cubic = readonly [Point2, Point2, Point2, Point2];

// A direction along the stroke is taken over this many tolerances, so that the hand's tremor does not turn it.
const kWindow = 6;
// A sharper turn, radians, is a corner that was meant.
const kCorner = Math.PI / 3;
// A piece is fitted again with better parameters while its error is below this many tolerances.
const kHopeful = 4;
const kMaxRounds = 6;
// Between two neighbouring points a piece may leave their chord by this share of the chord.
const kBulge = 0.3;
// Shorter handles than this share of a piece's chord would be kinks.
const kLeastHandle = 1e-3;

/**
 * Fits cubic pieces, joined end to start, to the points of a stroke. Each point is within `tolerance` of the curve.
 * Pieces meet smoothly, except where the stroke has a corner. A closed stroke, whose last point is its first, is smooth
 * there, too.
 *
 * Method: Schneider, "An algorithm for automatically fitting digitized curves", Graphics Gems (1990). Directions at ends
 * and joints are taken over a window of the stroke instead of between neighbours.
 */
export function fitCurve(points: readonly Point2[], tolerance: number): Cubic[] {
  const stroke = points.filter((point, i) => i === 0 || distance(point, points[i - 1]) > 0);
  if (stroke.length < 2) return [];
  const fit = new StrokeFit(stroke, tolerance);
  return fit.pieces();
}

/** Returns true for points whose turn is sharper than a hand draws a bend of this size. */
export function cornersOf(points: readonly Point2[], reach: number): boolean[] {
  const along = lengthsAlong(points);
  const turns = points.map((_, i) => (i === 0 || i === points.length - 1 ? 0 : turnAt(points, along, i, reach)));
  return turns.map((turn, i) => {
    if (turn < kCorner) return false;
    // The sharpest within reach is the corner.
    for (let k = i - 1; k > 0 && along[i] - along[k] <= reach; --k) if (turns[k] >= turn) return false;
    for (let k = i + 1; k < turns.length && along[k] - along[i] <= reach; ++k) if (turns[k] > turn) return false;
    return true;
  });
}

function lengthsAlong(points: readonly Point2[]): number[] {
  const along = [0];
  for (let i = 1; i < points.length; ++i) along.push(along[i - 1] + distance(points[i - 1], points[i]));
  return along;
}

// Returns the direction in which the stroke leaves point i, forward or (step -1) backward, over `reach` of its length.
function directionAt(points: readonly Point2[], along: readonly number[], i: number, step: 1 | -1, reach: number): Point2 {
  let k = i + step;
  while (k + step >= 0 && k + step < points.length && Math.abs(along[k] - along[i]) < reach) k += step;
  // A point much farther away than the reach says less of the direction here than a nearer one.
  if (k !== i + step && Math.abs(along[k] - along[i]) > 2 * reach) k -= step;
  return unit(sub(points[k], points[i]));
}

function turnAt(points: readonly Point2[], along: readonly number[], i: number, reach: number): number {
  const before = directionAt(points, along, i, -1, reach);
  const after = directionAt(points, along, i, 1, reach);
  return Math.PI - Math.acos(Math.min(1, Math.max(-1, dot(before, after))));
}

class StrokeFit {
  private readonly along: number[];
  private readonly reach: number;
  private readonly found: Cubic[] = [];

  constructor(
    private readonly points: readonly Point2[],
    private readonly tolerance: number,
  ) {
    this.along = lengthsAlong(points);
    this.reach = kWindow * tolerance;
  }

  pieces(): Cubic[] {
    const { points } = this;
    const isCorner = cornersOf(points, this.reach);
    const last = points.length - 1;
    const closing = this.closingDirection();
    let first = 0;
    for (let i = 1; i <= last; ++i) {
      if (i < last && !isCorner[i]) continue;
      const start = first === 0 && closing ? closing : this.direction(first, 1, i);
      const end = i === last && closing ? negated(closing) : this.direction(i, -1, first);
      this.fit(first, i, start, end);
      first = i;
    }
    return this.found;
  }

  // Returns the direction through start and end of a closed stroke; undefined if it is open or has a corner there.
  private closingDirection(): Point2 | undefined {
    const { points, reach } = this;
    const last = points.length - 1;
    if (last < 3 || distance(points[0], points[last]) > 0) return undefined;
    const half = Math.floor(last / 2);
    const turned = [...points.slice(half, last), ...points.slice(0, half + 1)];
    const along = lengthsAlong(turned);
    const at = last - half;
    if (turnAt(turned, along, at, reach) >= kCorner) return undefined;
    return unit(sub(directionAt(turned, along, at, 1, reach), directionAt(turned, along, at, -1, reach)));
  }

  // A direction that stays between i and `limit`.
  private direction(i: number, step: 1 | -1, limit: number): Point2 {
    const [low, high] = [Math.min(i, limit), Math.max(i, limit)];
    const part = this.points.slice(low, high + 1);
    return directionAt(part, this.along.slice(low, high + 1), i - low, step, this.reach);
  }

  private fit(first: number, last: number, start: Point2, end: Point2): void {
    const { points, tolerance } = this;
    if (last - first === 1) {
      this.found.push(spanned(points[first], points[last], start, end));
      return;
    }
    let parameters = this.chordParameters(first, last);
    let split = Math.floor((first + last) / 2);
    for (let round = 0; round <= kMaxRounds; ++round) {
      const piece = this.leastSquares(first, last, parameters, start, end);
      const worst = this.worst(first, piece, parameters);
      split = worst.index;
      if (worst.error <= tolerance && !this.bulges(first, piece, parameters)) {
        this.found.push(piece);
        return;
      }
      if (worst.error > kHopeful * tolerance) break;
      parameters = this.improved(first, piece, parameters);
    }
    split = Math.min(last - 1, Math.max(first + 1, split));
    const through = unit(sub(this.direction(split, 1, last), this.direction(split, -1, first)));
    this.fit(first, split, start, negated(through));
    this.fit(split, last, through, end);
  }

  private chordParameters(first: number, last: number): number[] {
    const length = this.along[last] - this.along[first];
    return Array.from({ length: last - first + 1 }, (_, i) => (this.along[first + i] - this.along[first]) / length);
  }

  // Returns the piece between two points, with these directions at its ends, that is closest to the points between them.
  private leastSquares(first: number, last: number, parameters: readonly number[], start: Point2, end: Point2): Cubic {
    const [p0, p3] = [this.points[first], this.points[last]];
    let [c00, c01, c11, x0, x1] = [0, 0, 0, 0, 0];
    parameters.forEach((t, i) => {
      const s = 1 - t;
      const [b0, b1, b2, b3] = [s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t];
      const [a0, a1] = [scaled(start, b1), scaled(end, b2)];
      c00 += dot(a0, a0);
      c01 += dot(a0, a1);
      c11 += dot(a1, a1);
      const p = this.points[first + i];
      const rest = { x: p.x - (b0 + b1) * p0.x - (b2 + b3) * p3.x, y: p.y - (b0 + b1) * p0.y - (b2 + b3) * p3.y };
      x0 += dot(a0, rest);
      x1 += dot(a1, rest);
    });
    const determinant = c00 * c11 - c01 * c01;
    const chord = distance(p0, p3);
    const [left, right] = [(x0 * c11 - x1 * c01) / determinant, (c00 * x1 - c01 * x0) / determinant];
    // A handle that is negative, vanishing or far too long is no part of a smooth stroke.
    const isPossible = (length: number) =>
      length > kLeastHandle * chord && length < this.along[last] - this.along[first] + chord;
    if (!isPossible(left) || !isPossible(right)) return spanned(p0, p3, start, end);
    return [p0, plus(p0, scaled(start, left)), plus(p3, scaled(end, right)), p3];
  }

  private worst(first: number, piece: Cubic, parameters: readonly number[]): { error: number; index: number } {
    const found = { error: 0, index: first + Math.floor(parameters.length / 2) };
    parameters.forEach((t, i) => {
      const error = distance(bezierPoint(piece, t), this.points[first + i]);
      if (error > found.error) [found.error, found.index] = [error, first + i];
    });
    return found;
  }

  // True if the piece leaves the stroke between two of its points.
  private bulges(first: number, piece: Cubic, parameters: readonly number[]): boolean {
    return parameters.slice(1).some((t, i) => {
      const [a, b] = [this.points[first + i], this.points[first + i + 1]];
      const middle = bezierPoint(piece, 0.5 * (t + parameters[i]));
      const chord = distance(a, b);
      const half = { x: 0.5 * (a.x + b.x), y: 0.5 * (a.y + b.y) };
      return distance(middle, half) > Math.max(2 * this.tolerance, (0.5 + kBulge) * chord) || t <= parameters[i];
    });
  }

  // Moves each parameter to that of the nearest point of the piece, by a step of Newton's method.
  private improved(first: number, piece: Cubic, parameters: readonly number[]): number[] {
    const [p0, p1, p2, p3] = piece;
    const d1 = [sub(p1, p0), sub(p2, p1), sub(p3, p2)].map((each) => scaled(each, 3));
    const d2 = [sub(d1[1], d1[0]), sub(d1[2], d1[1])].map((each) => scaled(each, 2));
    return parameters.map((t, i) => {
      const off = sub(bezierPoint(piece, t), this.points[first + i]);
      const [slope, bend] = [bezierPoint(d1, t), bezierPoint(d2, t)];
      const divisor = dot(slope, slope) + dot(off, bend);
      return divisor <= 0 ? t : Math.min(1, Math.max(0, t - dot(off, slope) / divisor));
    });
  }
}

// A piece whose handles are a third of its chord.
function spanned(from: Point2, to: Point2, start: Point2, end: Point2): Cubic {
  const length = distance(from, to) / 3;
  return [from, plus(from, scaled(start, length)), plus(to, scaled(end, length)), to];
}

function sub(a: Point2, b: Point2): Point2 {
  return { x: a.x - b.x, y: a.y - b.y };
}

function plus(a: Point2, b: Point2): Point2 {
  return { x: a.x + b.x, y: a.y + b.y };
}

function scaled({ x, y }: Point2, factor: number): Point2 {
  return { x: factor * x, y: factor * y };
}

function negated(a: Point2): Point2 {
  return scaled(a, -1);
}

function dot(a: Point2, b: Point2): number {
  return a.x * b.x + a.y * b.y;
}

function unit(a: Point2): Point2 {
  const length = Math.hypot(a.x, a.y);
  return length > 0 ? scaled(a, 1 / length) : { x: 1, y: 0 };
}
