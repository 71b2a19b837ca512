import type { SheetArrays } from '../stream/sheet_copy';
import type { Place, Point2 } from './locator';
import type { Surface } from './surface';

/** Points that stay on a sheet as it moves; valid until its triangles change. */
export interface Places {
  /** Slot of the triangle at each point. */
  readonly slots: Int32Array;
  /** Weights of the second and third corner at each point, 2 numbers each. */
  readonly weights: Float64Array;
}

// A chord beside the sheet is divided into pieces of this length, as a share of the sheet's larger side.
const kBesidePart = 1 / 64;
// A segment shorter than this share of the sheet's larger side has no direction in single precision and is left out.
const kLeastLength = 1e-6;
// A gap between two triangles that is a smaller share of the chord is a rounding error.
const kLeastGap = 1e-6;

function between(from: Point2, to: Point2, t: number): Point2 {
  return { x: (1 - t) * from.x + t * to.x, y: (1 - t) * from.y + t * to.y };
}

/**
 * Returns the parts of a chord. Each is in one triangle, given by its slot, or is a short piece beside the sheet: slot
 * undefined.
 */
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

class PlaceList {
  private readonly slots: number[] = [];
  private readonly weights: number[] = [];

  /** Adds all places, or none if one of them is undefined. */
  add(places: readonly (Place | undefined)[]): void {
    if (!places.every((place) => place !== undefined)) return;
    for (const { slot, u, v } of places) {
      this.slots.push(slot);
      this.weights.push(u, v);
    }
  }

  get places(): Places {
    return { slots: Int32Array.from(this.slots), weights: Float64Array.from(this.weights) };
  }
}

/**
 * Lays convex polygons, in material coordinates (m), onto a sheet. Returns the corners, 3 each, of triangles that fill
 * the polygons' parts on the sheet; each lies in one triangle of the sheet.
 */
export function placePolygons(polygons: readonly (readonly Point2[])[], surface: Surface): Places {
  const { locator } = surface;
  const list = new PlaceList();
  for (const polygon of polygons) {
    for (const slot of locator.slotsAround(polygon)) {
      const corners = clipped(polygon, locator.cornersOf(slot)).map((point) => locator.placeIn(slot, point));
      for (let i = 1; i + 1 < corners.length; ++i) list.add([corners[0], corners[i], corners[i + 1]]);
    }
  }
  return list.places;
}

/** Returns the part of a convex polygon inside a counter-clockwise triangle (Sutherland and Hodgman, 1974). */
function clipped(polygon: readonly Point2[], triangle: readonly Point2[]): readonly Point2[] {
  let left = polygon;
  for (let i = 0; i < 3 && left.length > 0; ++i) {
    const [from, to] = [triangle[i], triangle[(i + 1) % 3]];
    const inside = left.map(({ x, y }) => (to.x - from.x) * (y - from.y) - (to.y - from.y) * (x - from.x));
    left = left.flatMap((point, k) => {
      const next = (k + 1) % left.length;
      const kept = inside[k] >= 0 ? [point] : [];
      if (inside[k] >= 0 === inside[next] >= 0) return kept;
      return [...kept, between(point, left[next], inside[k] / (inside[k] - inside[next]))];
    });
  }
  return left.length > 2 ? left : [];
}

/**
 * Lays lines, in material coordinates (m), onto the triangles that they pass through. Returns the ends of segments, 2
 * each.
 */
export function traceLines(lines: readonly (readonly Point2[])[], surface: Surface): Places {
  const list = new PlaceList();
  const { min, max } = surface.locator;
  const leastLength = kLeastLength * Math.max(max.x - min.x, max.y - min.y);
  for (const line of lines) {
    for (let i = 0; i + 1 < line.length; ++i) {
      const length = Math.hypot(line[i + 1].x - line[i].x, line[i + 1].y - line[i].y);
      for (const { slot, start, end } of partsOf(line[i], line[i + 1], surface)) {
        if ((end - start) * length < leastLength) continue;
        const ends = [start, end].map((t) => between(line[i], line[i + 1], t));
        list.add(ends.map((at) => (slot === undefined ? surface.placeOf(at) : surface.locator.placeIn(slot, at))));
      }
    }
  }
  return list.places;
}

/** Writes the world positions of the points, metres, 3 numbers each. */
export function writePositions({ slots, weights }: Places, sheet: SheetArrays, out: Float32Array): void {
  const { positions: x, triangles } = sheet;
  for (let i = 0; i < slots.length; ++i) {
    const [a, b, c] = [3 * triangles[3 * slots[i]], 3 * triangles[3 * slots[i] + 1], 3 * triangles[3 * slots[i] + 2]];
    const [u, v] = [weights[2 * i], weights[2 * i + 1]];
    const w = 1 - u - v;
    for (let k = 0; k < 3; ++k) out[3 * i + k] = w * x[a + k] + u * x[b + k] + v * x[c + k];
  }
}
