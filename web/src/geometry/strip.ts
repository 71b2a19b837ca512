import type { Point2 } from './locator';

// Corners that turn by more than this, radians, are rounded like ends; others are filled by a triangle.
const kCorner = 0.5;
// Sides of the polygon that replaces a disc.
const kDiscSides = 16;

/**
 * Returns the parts of lines that a pattern keeps. Its lengths are kept and left out in turn; the pattern begins again
 * on each line.
 *
 * @param lengths  > 0, an even number of them; none: the whole lines are kept
 */
export function dashes(lines: readonly (readonly Point2[])[], lengths: readonly number[]): Point2[][] {
  if (lengths.length === 0) return lines.map((line) => [...line]);
  return lines.flatMap((line) => dashesOf(line, lengths));
}

function dashesOf(line: readonly Point2[], lengths: readonly number[]): Point2[][] {
  const found: Point2[][] = [];
  let turn = 0;
  let left = lengths[0];
  let dash: Point2[] = line.slice(0, 1);
  for (let i = 0; i + 1 < line.length; ++i) {
    const [from, to] = [line[i], line[i + 1]];
    const length = Math.hypot(to.x - from.x, to.y - from.y);
    let done = 0;
    while (length - done > left) {
      done += left;
      const at = { x: from.x + (done / length) * (to.x - from.x), y: from.y + (done / length) * (to.y - from.y) };
      if (turn % 2 === 0) found.push([...dash, at]);
      dash = [at];
      turn += 1;
      left = lengths[turn % lengths.length];
    }
    left -= length - done;
    dash.push(to);
  }
  if (turn % 2 === 0 && dash.length > 1) found.push(dash);
  return found;
}

/**
 * Returns polygons whose union is the strip of this width around a line, as swept by a disc that follows the line. One
 * is around each chord, others are at ends and corners. All have the same orientation.
 */
export function stripPolygons(line: readonly Point2[], width: number): Point2[][] {
  const radius = 0.5 * width;
  const points = line.filter(({ x, y }, i) => i === 0 || x !== line[i - 1].x || y !== line[i - 1].y);
  if (points.length === 0) return [];
  const chords = points.slice(1).map((to, i) => new Chord(points[i], to, radius));
  const last = points.length - 1;
  const isClosed = last > 1 && points[0].x === points[last].x && points[0].y === points[last].y;
  const ends = isClosed ? [] : [disc(points[0], radius), disc(points[last], radius)];
  const joints = chords.flatMap((chord, i) => {
    const next = chords[i + 1] ?? (isClosed ? chords[0] : undefined);
    return next ? [joint(chord, next)] : [];
  });
  return [...ends, ...chords.map((chord) => chord.outline()), ...joints];
}

class Chord {
  /** Vector to the left of the chord, of half the strip's width. */
  readonly normal: Point2;

  constructor(
    readonly from: Point2,
    readonly to: Point2,
    readonly radius: number,
  ) {
    const [x, y] = [to.x - from.x, to.y - from.y];
    const scale = radius / Math.hypot(x, y);
    this.normal = { x: -scale * y, y: scale * x };
  }

  outline(): Point2[] {
    const { from, to, normal } = this;
    return [moved(from, normal, -1), moved(to, normal, -1), moved(to, normal, 1), moved(from, normal, 1)];
  }
}

function joint(chord: Chord, next: Chord): Point2[] {
  const { normal: a, to: at, radius } = chord;
  const { normal: b } = next;
  const turn = Math.atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y);
  if (Math.abs(turn) > kCorner) return disc(at, radius);
  // A triangle on the outer side of the bend.
  return turn > 0 ? [at, moved(at, a, -1), moved(at, b, -1)] : [at, moved(at, b, 1), moved(at, a, 1)];
}

function disc({ x, y }: Point2, radius: number): Point2[] {
  return Array.from({ length: kDiscSides }, (_, i) => {
    const angle = (2 * Math.PI * i) / kDiscSides;
    return { x: x + radius * Math.cos(angle), y: y + radius * Math.sin(angle) };
  });
}

function moved(at: Point2, by: Point2, times: number): Point2 {
  return { x: at.x + times * by.x, y: at.y + times * by.y };
}
