import { bezierPoint, flattened } from './curve';
import type { Flatness } from './curve';
import type { Point2 } from './locator';
import { svgArc } from './svg_arc';
import type { ArcNumbers } from './svg_arc';

const kNumber = /[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?/gi;
const kCounts: Record<string, number> = { M: 2, L: 2, H: 1, V: 1, C: 6, S: 4, Q: 4, T: 2, A: 7, Z: 0 };

/** Estimates how many segments path data has. */
export function countSegments(data: string): number {
  return Math.ceil((data.match(kNumber)?.length ?? 0) / 4);
}

/**
 * Converts path data (SVG 1.1, chapter 8.3) to polylines, one per subpath, for a preview. Malformed parts are left out.
 */
export function pathLines(data: string, flatness: Flatness): Point2[][] {
  const lines: Point2[][] = [];
  let line: Point2[] = [];
  let at: Point2 = { x: 0, y: 0 };
  // The last but one control point of the previous curve, for S and T.
  let control: Point2 | undefined;
  let curve = '';

  const run = (letter: string, n: readonly number[]): void => {
    const name = letter.toUpperCase();
    const origin = letter === name ? { x: 0, y: 0 } : at;
    const point = (i: number): Point2 => ({ x: origin.x + n[i], y: origin.y + n[i + 1] });
    const mirrored = (of: string): Point2 =>
      control && of.includes(curve) ? { x: 2 * at.x - control.x, y: 2 * at.y - control.y } : at;
    const follow = (curve: (t: number) => Point2): void => void line.push(...flattened(curve, flatness).slice(1));
    const bend = (...points: Point2[]): void => {
      const all = [at, ...points];
      follow((t) => bezierPoint(all, t));
      control = points[points.length - 2];
    };
    const turn = (end: Point2): void => {
      const arc = svgArc(at, end, n.slice(0, 5) as unknown as ArcNumbers);
      if (arc) follow((t) => (t === 1 ? end : arc(t)));
      else line.push(end);
    };
    if (name === 'M' || line.length === 0) lines.push((line = [name === 'M' ? point(0) : at]));
    if (name === 'L') line.push(point(0));
    else if (name === 'H') line.push({ x: origin.x + n[0], y: at.y });
    else if (name === 'V') line.push({ x: at.x, y: origin.y + n[0] });
    else if (name === 'C') bend(point(0), point(2), point(4));
    else if (name === 'S') bend(mirrored('CS'), point(0), point(2));
    else if (name === 'Q') bend(point(0), point(2));
    else if (name === 'T') bend(mirrored('QT'), point(0));
    else if (name === 'A') turn(point(5));
    else if (name === 'Z') line.push(line[0]);
    at = line[line.length - 1];
    curve = name;
    // The next segment begins another subpath, at the start of this one.
    if (name === 'Z') line = [];
  };

  for (const [letter, numbers] of segments(data)) run(letter, numbers);
  return lines.filter(({ length }) => length > 1);
}

/** Returns path data for each subpath alone, at its exact place. Subpaths that draw nothing are left out. */
export function subpaths(data: string): string[] {
  const parts: { move: string; rest: string }[] = [];
  let at: Point2 = { x: 0, y: 0 };
  let start = at;
  let isOpen = false;
  const begin = (): void => {
    start = at;
    parts.push({ move: `M${at.x} ${at.y}`, rest: '' });
  };
  for (const [letter, numbers] of segments(data)) {
    const name = letter.toUpperCase();
    if (name !== 'M' && !isOpen) begin();
    at = name === 'Z' ? start : endOf(letter, numbers, at);
    if (name === 'M') begin();
    else parts[parts.length - 1].rest += letter + numbers.join(' ');
    isOpen = name !== 'Z';
  }
  return parts.filter(({ rest }) => rest !== '').map(({ move, rest }) => move + rest);
}

// Returns the end of a segment of any kind except Z, which ends at its subpath's start.
function endOf(letter: string, numbers: readonly number[], at: Point2): Point2 {
  const name = letter.toUpperCase();
  const origin = letter === name ? { x: 0, y: 0 } : at;
  if (name === 'H') return { x: origin.x + numbers[0], y: at.y };
  if (name === 'V') return { x: at.x, y: origin.y + numbers[0] };
  const [x, y] = numbers.slice(-2);
  return { x: origin.x + x, y: origin.y + y };
}

// Yields the segments one by one, each with its letter, which the data may write once for several segments.
function* segments(data: string): Generator<[letter: string, numbers: number[]]> {
  for (const [, letter, rest] of data.matchAll(/([mlhvcsqtaz])([^mlhvcsqtaz]*)/gi)) {
    const name = letter.toUpperCase();
    const numbers = name === 'A' ? arcNumbers(rest) : (rest.match(kNumber) ?? []).map(Number);
    const count = kCounts[name];
    if (count === 0) yield [letter, []];
    for (let i = 0; count > 0 && i + count <= numbers.length; i += count) {
      // Pairs after the first of a move are lines.
      yield [name === 'M' && i > 0 ? (letter === 'M' ? 'L' : 'l') : letter, numbers.slice(i, i + count)];
    }
  }
}

// Reads the numbers of arcs. Their two flags may have no separator before the next number: "a 1 1 0 015 5".
function arcNumbers(text: string): number[] {
  const numbers: number[] = [];
  let rest = text;
  for (;;) {
    rest = rest.replace(/^[\s,]+/, '');
    const isFlag = numbers.length % 7 === 3 || numbers.length % 7 === 4;
    const found = (isFlag ? /^[01]/ : /^[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?/i).exec(rest);
    if (!found) return numbers;
    numbers.push(Number(found[0]));
    rest = rest.slice(found[0].length);
  }
}
