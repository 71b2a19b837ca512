import { describe, expect, it } from 'vitest';
import type { Point2 } from '../src/geometry/locator';
import { Surface } from '../src/geometry/surface';
import { placePolygons, traceLines, writePositions } from '../src/geometry/trace';
import { SheetMirror } from '../src/stream/mirror';
import type { Places } from '../src/geometry/trace';

type Point3 = [number, number, number];

// Rolled to a quarter of a cylinder along x, with waves along y.
function bent(x: number, y: number): Point3 {
  const angle = 0.5 * Math.PI * x;
  const radius = 2 / Math.PI + 0.05 * Math.sin(9 * y);
  return [radius * Math.sin(angle), y, radius * Math.cos(angle)];
}

/** A bent unit square of n x n uneven squares. `isSlit`: open along x = 0.5 for y > 0.5, where the right half is moved away. */
function bentSheet(n: number, isSlit = false): Surface {
  const mirror = new SheetMirror();
  const uneven = (i: number, j: number) => {
    const isInner = i > 0 && i < n && j > 0 && j < n && 2 * i !== n;
    const shift = isInner ? 0.3 * Math.sin(7 * i + 3 * j) : 0;
    return [(i + shift) / n, (j + 0.7 * shift) / n];
  };
  const side = n + 1;
  const material = Array.from({ length: side * side }, (_, v) => uneven(v % side, Math.floor(v / side)));
  const positions = material.map(([x, y]) => bent(x, y));
  const doubled = new Map<number, number>();
  for (let j = 0; isSlit && j <= n; ++j) {
    if (2 * j <= n) continue;
    const v = j * side + n / 2;
    doubled.set(v, material.length);
    material.push(material[v]);
    positions.push(bent(material[v][0], material[v][1]).map((c, k) => (k === 0 ? c + 0.2 : c)) as Point3);
  }
  const triangles: number[] = [];
  for (let j = 0; j < n; ++j) {
    for (let i = 0; i < n; ++i) {
      const a = j * side + i;
      const corners = [a, a + 1, a + side + 1, a, a + side + 1, a + side];
      const isRight = 2 * i >= n;
      triangles.push(...corners.map((v) => (isRight ? (doubled.get(v) ?? v) : v)));
    }
  }
  mirror.numVertices = material.length;
  mirror.materialPositions = Float32Array.from(material.flat());
  mirror.positions = Float32Array.from(positions.flat());
  mirror.triangles = Int32Array.from([...triangles, -1, -1, -1]);
  mirror.numSlots = mirror.triangles.length / 3;
  mirror.topologyVersion = 1;
  return new Surface(mirror);
}

const minus = (a: Point3, b: Point3): Point3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a: Point3, b: Point3) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Point3, b: Point3): Point3 => {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
};
const length = (a: Point3) => Math.sqrt(dot(a, a));

/** Distance from a point to a triangle that it lies above or in; Infinity beside it by more than rounding. */
function distanceToTriangle(p: Point3, [a, b, c]: Point3[]): number {
  const normal = cross(minus(b, a), minus(c, a));
  const area = length(normal);
  const isInside = [[a, b], [b, c], [c, a]].every(([from, to]) => {
    return dot(cross(minus(to, from), minus(p, from)), normal) / area >= -1e-6 * length(minus(to, from));
  });
  return isInside ? Math.abs(dot(minus(p, a), normal)) / area : Infinity;
}

function cornersOf({ mirror }: Surface, slot: number): Point3[] {
  return [0, 1, 2].map((k) => {
    const v = 3 * mirror.triangles[3 * slot + k];
    return [mirror.positions[v], mirror.positions[v + 1], mirror.positions[v + 2]];
  });
}

function positionsOf(places: Places, { mirror }: Surface): Point3[] {
  const out = new Float32Array(3 * places.slots.length);
  writePositions(places, mirror, out);
  return Array.from(places.slots, (_, i) => [...out.subarray(3 * i, 3 * i + 3)] as Point3);
}

function worldOf(lines: readonly (readonly Point2[])[], surface: Surface) {
  const trace = traceLines(lines, surface);
  return { trace, ends: positionsOf(trace, surface) };
}

const kSquare = [
  [0.1, 0.1],
  [0.9, 0.1],
  [0.9, 0.9],
  [0.1, 0.9],
  [0.1, 0.1],
].map(([x, y]) => ({ x, y }));
const kCircle = Array.from({ length: 129 }, (_, i) => {
  const angle = ((i % 128) * Math.PI) / 64;
  return { x: 0.5 + 0.37 * Math.cos(angle), y: 0.5 + 0.37 * Math.sin(angle) };
});

describe('traceLines', () => {
  it.each([
    ['straight sides, of which some run along edges', kSquare],
    ['a circle', kCircle],
    ['the middle, along edges', [{ x: 0.5, y: 0 }, { x: 0.5, y: 1 }]],
    ['the border', [{ x: 0, y: 0 }, { x: 1, y: 0 }, { x: 1, y: 1 }]],
  ])('lays all of a line on the triangles of a bent sheet: %s', (_, line) => {
    const surface = bentSheet(20);
    const { trace, ends } = worldOf([line], surface);
    ends.forEach((end, i) => {
      expect(distanceToTriangle(end, cornersOf(surface, trace.slots[i]))).toBeLessThan(1e-6);
      // Both ends of a segment are in one triangle, and so is all between them.
      expect(trace.slots[i]).toBe(trace.slots[i - (i % 2)]);
      // One segment begins where the one before has ended.
      if (i % 2 === 0 && i > 0) expect(length(minus(end, ends[i - 1]))).toBeLessThan(2e-6);
    });
  });

  it('has all of a line once: its parts are as long together as the line in material', () => {
    const surface = bentSheet(20);
    const { materialPositions: m, triangles } = surface.mirror;
    for (const line of [kSquare, kCircle]) {
      const { slots, weights } = traceLines([line], surface);
      const at = (end: number, axis: number) => {
        const [a, b, c] = [0, 1, 2].map((k) => m[2 * triangles[3 * slots[end] + k] + axis]);
        const [u, v] = [weights[2 * end], weights[2 * end + 1]];
        return (1 - u - v) * a + u * b + v * c;
      };
      let sum = 0;
      for (let i = 0; 2 * i < slots.length; ++i) {
        sum += Math.hypot(at(2 * i + 1, 0) - at(2 * i, 0), at(2 * i + 1, 1) - at(2 * i, 1));
      }
      const whole = line.slice(1).reduce((all, to, i) => all + Math.hypot(to.x - line[i].x, to.y - line[i].y), 0);
      expect(sum).toBeCloseTo(whole, 6);
    }
  });

  it('does not bridge a slit that stands open', () => {
    const surface = bentSheet(20, true);
    const { ends } = worldOf([[{ x: 0.3, y: 0.83 }, { x: 0.7, y: 0.83 }]], surface);
    const jumps = ends.filter((end, i) => i % 2 === 0 && i > 0 && length(minus(end, ends[i - 1])) > 0.1);
    expect(jumps).toHaveLength(1);
    for (let i = 0; i < ends.length; i += 2) expect(length(minus(ends[i + 1], ends[i]))).toBeLessThan(0.15);
  });

  it('continues beside the sheet in short pieces, along the nearest triangle', () => {
    const surface = bentSheet(20);
    const { ends } = worldOf([[{ x: -0.2, y: 0.5 }, { x: 0.3, y: 0.5 }]], surface);
    const [first] = ends;
    // On beside the border as the sheet begins there, at x = 0.
    expect(first[0]).toBeLessThan(-0.15);
    for (let i = 1; i < ends.length; ++i) expect(length(minus(ends[i], ends[i - 1]))).toBeLessThan(0.08);
    expect(worldOf([[{ x: 0.2, y: 0.2 }, { x: 0.2, y: 0.2 }]], surface).ends).toEqual([]);
    expect(worldOf([[{ x: 2, y: 2 }, { x: 3, y: 3 }]], surface).ends.length).toBeGreaterThan(60);
  });

  it('follows the sheet as it moves', () => {
    const surface = bentSheet(20);
    const trace = traceLines([kCircle], surface);
    const before = positionsOf(trace, surface);
    surface.mirror.positions.forEach((value, i, all) => (all[i] = 2 * value));
    const after = positionsOf(trace, surface);
    after.forEach((point, i) => expect(length(minus(point, before[i]))).toBeCloseTo(length(before[i]), 5));
  });
});

describe('placePolygons', () => {
  const square = (x: number, y: number, side: number) => {
    return [{ x, y }, { x: x + side, y }, { x: x + side, y: y + side }, { x, y: y + side }];
  };
  /** Area in the material of triangles by their corners. */
  const areaOf = ({ slots, weights }: Places, { mirror }: Surface) => {
    const m = mirror.materialPositions;
    const at = (i: number, axis: number) => {
      const [a, b, c] = [0, 1, 2].map((k) => m[2 * mirror.triangles[3 * slots[i] + k] + axis]);
      return a + weights[2 * i] * (b - a) + weights[2 * i + 1] * (c - a);
    };
    let sum = 0;
    for (let i = 0; i < slots.length; i += 3) {
      const [abX, abY] = [at(i + 1, 0) - at(i, 0), at(i + 1, 1) - at(i, 1)];
      const [acX, acY] = [at(i + 2, 0) - at(i, 0), at(i + 2, 1) - at(i, 1)];
      sum += 0.5 * (abX * acY - abY * acX);
    }
    return sum;
  };

  it('fill all of a polygon, by triangles of which each lies in one of the bent sheet', () => {
    const surface = bentSheet(20);
    for (const polygon of [square(0.312, 0.123, 0.004), square(0.2, 0.3, 0.5), kCircle.slice(1)]) {
      const places = placePolygons([polygon], surface);
      positionsOf(places, surface).forEach((corner, i) => {
        expect(distanceToTriangle(corner, cornersOf(surface, places.slots[i]))).toBeLessThan(1e-6);
        expect(places.slots[i]).toBe(places.slots[i - (i % 3)]);
      });
      const whole = 0.5 * polygon.reduce((sum, { x, y }, i) => {
        const next = polygon[(i + 1) % polygon.length];
        return sum + x * next.y - y * next.x;
      }, 0);
      expect(areaOf(places, surface)).toBeCloseTo(whole, 6);
    }
  });

  it('leave out what is beside the sheet, and bridge no slit', () => {
    const surface = bentSheet(20, true);
    const overhanging = placePolygons([square(0.9, 0.4, 0.2)], surface);
    expect(areaOf(overhanging, surface)).toBeCloseTo(0.02, 6);
    expect(placePolygons([square(2, 2, 1)], surface).slots).toHaveLength(0);
    // Each triangle is on one side of the slit.
    const { slots } = placePolygons([square(0.45, 0.7, 0.1)], surface);
    expect(slots.length).toBeGreaterThan(0);
    slots.forEach((slot, i) => expect(slot).toBe(slots[i - (i % 3)]));
  });
});
