import type { SheetArrays } from '../stream/sheet_copy';
import type { Place, Point2 } from './locator';
import type { Surface } from './surface';

/** Segments that lie on a sheet, wherever it moves, until its triangles change. */
export interface Trace {
  readonly numSegments: number;
  /** Slot of each end, 2 numbers a segment. */
  readonly slots: Int32Array;
  /** Weights of the second and third corner at each end, 4 numbers a segment. */
  readonly weights: Float64Array;
}

// A chord beside the sheet is divided into pieces of this part of the sheet's larger side.
const kBesidePart = 1 / 64;
// A gap between two triangles that is a smaller part of the chord is rounding.
const kLeastGap = 1e-6;

function between(from: Point2, to: Point2, t: number): Point2 {
  return { x: (1 - t) * from.x + t * to.x, y: (1 - t) * from.y + t * to.y };
}

/** The parts of a chord, each in one triangle (its slot) or, in short pieces, beside the sheet (undefined). */
function partsOf(from: Point2, to: Point2, surface: Surface): { slot: number | undefined; start: number; end: number }[] {
  const { min, max } = surface.locator;
  const step = kBesidePart * Math.max(max.x - min.x, max.y - min.y);
  const length = Math.hypot(to.x - from.x, to.y - from.y);
  const parts: { slot: number | undefined; start: number; end: number }[] = [];
  let done = 0;
  const fill = (end: number): void => {
    const count = end - done > kLeastGap ? Math.ceil(((end - done) * length) / step) : 0;
    const start = done;
    const at = (i: number) => start + (i / count) * (end - start);
    for (let i = 0; i < count; ++i) parts.push({ slot: undefined, start: at(i), end: at(i + 1) });
  };
  for (const crossing of length > 0 ? surface.locator.along(from, to) : []) {
    fill(crossing.start);
    parts.push(crossing);
    done = crossing.end;
  }
  if (length > 0) fill(1);
  return parts;
}

/** Lays lines, in metres of material, onto the triangles that they pass through. */
export function traceLines(lines: readonly (readonly Point2[])[], surface: Surface): Trace {
  const slots: number[] = [];
  const weights: number[] = [];
  const add = (...ends: (Place | undefined)[]): void => {
    if (!ends.every((end) => end !== undefined)) return;
    for (const { slot, u, v } of ends) {
      slots.push(slot);
      weights.push(u, v);
    }
  };
  for (const line of lines) {
    for (let i = 0; i + 1 < line.length; ++i) {
      for (const { slot, start, end } of partsOf(line[i], line[i + 1], surface)) {
        const ends = [start, end].map((t) => between(line[i], line[i + 1], t));
        add(...ends.map((at) => (slot === undefined ? surface.placeOf(at) : surface.locator.placeIn(slot, at))));
      }
    }
  }
  return { numSegments: slots.length / 2, slots: Int32Array.from(slots), weights: Float64Array.from(weights) };
}

/** World positions of a trace's ends, metres: 6 numbers a segment. */
export function placeTrace({ slots, weights }: Trace, sheet: SheetArrays, out: Float32Array): void {
  const { positions: x, triangles } = sheet;
  for (let i = 0; i < slots.length; ++i) {
    const [a, b, c] = [3 * triangles[3 * slots[i]], 3 * triangles[3 * slots[i] + 1], 3 * triangles[3 * slots[i] + 2]];
    const [u, v] = [weights[2 * i], weights[2 * i + 1]];
    const w = 1 - u - v;
    for (let k = 0; k < 3; ++k) out[3 * i + k] = w * x[a + k] + u * x[b + k] + v * x[c + k];
  }
}

/** The same line with a point wherever it leaves a triangle, and several beside the sheet: its chords bend with it. */
export function subdivided(line: readonly Point2[], surface: Surface): Point2[] {
  const points = line.slice(0, 1);
  for (let i = 0; i + 1 < line.length; ++i) {
    for (const { end } of partsOf(line[i], line[i + 1], surface)) {
      points.push(end > 1 - kLeastGap ? line[i + 1] : between(line[i], line[i + 1], end));
    }
  }
  return points;
}
