import { PerspectiveCamera, Ray, Vector2, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { boundaryEdges } from '../src/geometry/boundary';
import { bezierPoint, distance, ellipsePoints, flattened, simplify } from '../src/geometry/curve';
import { Locator } from '../src/geometry/locator';
import { vertexNormals } from '../src/geometry/normals';
import { Surface } from '../src/geometry/surface';
import { SheetMirror } from '../src/stream/mirror';

const kSide = 5;

/** A unit square of 5 x 5 vertices, at (1 + 2 x, y, 3): stretched along x, so that material and world differ. */
function squareMirror(): SheetMirror {
  const mirror = new SheetMirror();
  const material: number[] = [];
  const triangles: number[] = [];
  for (let j = 0; j < kSide; ++j) {
    for (let i = 0; i < kSide; ++i) material.push(i / (kSide - 1), j / (kSide - 1));
  }
  for (let j = 0; j + 1 < kSide; ++j) {
    for (let i = 0; i + 1 < kSide; ++i) {
      const a = j * kSide + i;
      triangles.push(a, a + 1, a + kSide + 1, a, a + kSide + 1, a + kSide);
    }
  }
  mirror.numVertices = kSide * kSide;
  mirror.materialPositions = Float32Array.from(material);
  mirror.positions = new Float32Array(3 * mirror.numVertices);
  for (let v = 0; v < mirror.numVertices; ++v)
    mirror.positions.set([1 + 2 * material[2 * v], material[2 * v + 1], 3], 3 * v);
  mirror.triangles = Int32Array.from([...triangles, -1, -1, -1]);
  mirror.numSlots = mirror.triangles.length / 3;
  mirror.topologyVersion = 1;
  return mirror;
}

function edgeSet(edges: Uint32Array): Set<string> {
  return new Set(Array.from({ length: edges.length / 3 }, (_, i) => `${edges[3 * i]}-${edges[3 * i + 1]}`));
}

describe('boundaryEdges', () => {
  it('finds the border of a square, triangle on the left', () => {
    const { triangles, numSlots, numVertices } = squareMirror();
    const edges = edgeSet(boundaryEdges(triangles, numSlots, numVertices));
    expect(edges.size).toBe(4 * (kSide - 1));
    expect(edges).toContain('0-1');
    expect(edges).toContain('5-0');
    expect(edges).not.toContain('1-0');
  });

  it('finds both lips of a slit', () => {
    // Two triangles that shared an edge 0-2, opened by doubling both its vertices as 4 and 5.
    const edges = edgeSet(boundaryEdges(Int32Array.of(0, 1, 2, 4, 5, 3), 2, 6));
    expect(edges).toEqual(new Set(['0-1', '1-2', '2-0', '4-5', '5-3', '3-4']));
  });
});

describe('Locator', () => {
  const mirror = squareMirror();
  const locator = new Locator(mirror.materialPositions, mirror.numVertices, mirror.triangles, mirror.numSlots);

  it('finds the triangle and weights of every point of the sheet, corners and edges included', () => {
    for (let i = 0; i <= 40; ++i) {
      for (let j = 0; j <= 40; ++j) {
        const point = { x: i / 40, y: j / 40 };
        const place = locator.find(point);
        expect(place).toBeDefined();
        const [a, b, c] = [0, 1, 2].map((k) => 2 * mirror.triangles[3 * place!.slot + k]);
        const m = mirror.materialPositions;
        const at = (axis: number) =>
          (1 - place!.u - place!.v) * m[a + axis] + place!.u * m[b + axis] + place!.v * m[c + axis];
        expect(at(0)).toBeCloseTo(point.x, 6);
        expect(at(1)).toBeCloseTo(point.y, 6);
      }
    }
  });

  it('finds nothing off the sheet', () => {
    expect(locator.find({ x: 1.01, y: 0.5 })).toBeUndefined();
    expect(locator.find({ x: 0.5, y: -0.01 })).toBeUndefined();
    expect(locator.find({ x: Number.NaN, y: 0 })).toBeUndefined();
  });
});

describe('Surface', () => {
  const surface = new Surface(squareMirror());

  it('hits the sheet from both sides and gives material point and nearest vertex', () => {
    for (const side of [1, -1]) {
      const hit = surface.pick(new Ray(new Vector3(1.55, 0.74, 3 + 5 * side), new Vector3(0, 0, -side)));
      expect(hit?.material.x).toBeCloseTo(0.275, 6);
      expect(hit?.material.y).toBeCloseTo(0.74, 6);
      expect(hit?.world.z).toBeCloseTo(3, 6);
      expect(hit?.vertex).toBe(3 * kSide + 1);
    }
  });

  it('misses beside the sheet and behind the origin of the ray', () => {
    expect(surface.pick(new Ray(new Vector3(0.9, 0.5, 8), new Vector3(0, 0, -1)))).toBeUndefined();
    expect(surface.pick(new Ray(new Vector3(2, 0.5, 2), new Vector3(0, 0, -1)))).toBeUndefined();
  });

  it('maps material points to the world, on the sheet and beside it', () => {
    expect(surface.toWorld({ x: 0.3, y: 0.6 })?.distanceTo(new Vector3(1.6, 0.6, 3))).toBeLessThan(1e-6);
    expect(surface.toWorld({ x: -0.1, y: 0.6 })?.distanceTo(new Vector3(0.8, 0.6, 3))).toBeLessThan(1e-6);
  });

  it('takes a click beside the border as a point beside the sheet', () => {
    const camera = new PerspectiveCamera(40, 1, 0.1, 100);
    camera.position.set(2, 0.5, 10);
    camera.lookAt(2, 0.5, 3);
    camera.updateMatrixWorld();
    const size = new Vector2(1000, 1000);
    const metresPerPx = (2 * 7 * Math.tan((20 * Math.PI) / 180)) / 1000;
    const px = new Vector3(2, -0.2, 3).project(camera);
    const click = new Vector2((0.5 + 0.5 * px.x) * 1000, (0.5 - 0.5 * px.y) * 1000);
    const point = surface.pickBeside(click, camera, size, () => metresPerPx);
    expect(point?.x).toBeCloseTo(0.5, 4);
    expect(point?.y).toBeCloseTo(-0.2, 4);
    expect(surface.pickBeside(new Vector2(5, 5), camera, size, () => metresPerPx)).toBeUndefined();
  });
});

describe('vertexNormals', () => {
  it('are unit and point to the side on which the material runs counter-clockwise', () => {
    const { positions, numVertices, triangles, numSlots } = squareMirror();
    const normals = new Float32Array(3 * numVertices).fill(7);
    vertexNormals(positions, numVertices, triangles, numSlots, normals);
    for (let v = 0; v < numVertices; ++v) expect([...normals.subarray(3 * v, 3 * v + 3)]).toEqual([0, 0, 1]);
  });
});

describe('curves', () => {
  const points = [
    { x: 0, y: 0 },
    { x: 0, y: 3 },
    { x: 3, y: 3 },
    { x: 3, y: 0 },
  ];

  it('follow the cubic Bernstein polynomials', () => {
    expect(bezierPoint(points, 0)).toEqual(points[0]);
    expect(bezierPoint(points, 1)).toEqual(points[3]);
    expect(bezierPoint(points, 0.5)).toEqual({ x: 1.5, y: 2.25 });
  });

  it('may be quadratic, and rational: with weights 1, 1, 2 a quarter of a circle', () => {
    const corner = [points[0], points[1], points[2]];
    expect(bezierPoint(corner, 0.5)).toEqual({ x: 0.75, y: 2.25 });
    const arc = [
      { x: 1, y: 0 },
      { x: 1, y: 1 },
      { x: 0, y: 1 },
    ];
    for (let i = 0; i <= 10; ++i) {
      const { x, y } = bezierPoint(arc, i / 10, [1, 1, 2]);
      expect(Math.hypot(x, y)).toBeCloseTo(1, 12);
    }
  });

  it('include ellipses by centre and two ends of axes, closed exactly', () => {
    const [center, a, b] = [
      { x: 1, y: 2 },
      { x: 1, y: 5 },
      { x: -1, y: 2 },
    ];
    const ellipse = ellipsePoints(center, a, b, 8);
    expect(ellipse).toHaveLength(9);
    expect(ellipse[8]).toEqual(ellipse[0]);
    expect(distance(ellipse[0], a)).toBeLessThan(1e-12);
    expect(distance(ellipse[2], b)).toBeLessThan(1e-12);
    for (const { x, y } of ellipse) expect(((y - 2) / 3) ** 2 + ((x - 1) / 2) ** 2).toBeCloseTo(1, 12);
  });

  it.each([
    ['cubic', points, undefined],
    ['cubic with a loop', [points[0], { x: 5, y: 3 }, { x: -2, y: 3 }, points[3]], undefined],
    ['with a strong weight', points, [1, 20, 0.05, 1]],
  ])('are followed as closely as asked for: %s', (_, control, weights) => {
    const at = (t: number) => bezierPoint(control, t, weights);
    for (const tolerance of [1e-2, 1e-4]) {
      const line = flattened(at, { tolerance, depth: 12 });
      expect([line[0], line.at(-1)]).toEqual([at(0), at(1)]);
      let farthest = 0;
      for (let i = 0; i <= 3000; ++i) {
        const p = at(i / 3000);
        const distances = line.slice(1).map((b, k) => {
          const a = line[k];
          const along = ((p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y)) / (distance(a, b) ** 2 || 1);
          const t = Math.min(1, Math.max(0, along));
          return distance(p, { x: a.x + t * (b.x - a.x), y: a.y + t * (b.y - a.y) });
        });
        farthest = Math.max(farthest, Math.min(...distances));
      }
      expect(farthest).toBeLessThanOrEqual(tolerance);
    }
  });

  it('are halved no more often than may be', () => {
    expect(flattened((t) => bezierPoint(points, t), { tolerance: 0, depth: 3 })).toHaveLength(9);
    expect(flattened((t) => bezierPoint(points, t), { tolerance: 0, depth: 0 })).toEqual([points[0], points[3]]);
  });

  it('are reduced to the points that matter', () => {
    const corner = [
      { x: 0, y: 0 },
      { x: 0.5, y: 0.001 },
      { x: 1, y: 0 },
      { x: 1, y: 0.5 },
      { x: 1, y: 1 },
    ];
    expect(simplify(corner, 0.002)).toEqual([corner[0], corner[2], corner[4]]);
    expect(simplify(corner.slice(0, 2), 0.002)).toEqual(corner.slice(0, 2));
  });

  it('stay within the tolerance of every point, with far fewer of them', () => {
    const wave = Array.from({ length: 2000 }, (_, i) => ({ x: i / 1999, y: 0.2 * Math.sin(i / 300) }));
    const line = simplify(wave, 0.002);
    expect(line.length).toBeGreaterThan(5);
    expect(line.length).toBeLessThan(50);
    for (const point of wave) {
      const i = line.findIndex((end, k) => k > 0 && end.x >= point.x);
      const [a, b] = [line[i - 1], line[i]];
      const across = (b.x - a.x) * (point.y - a.y) - (b.y - a.y) * (point.x - a.x);
      expect(Math.abs(across) / Math.hypot(b.x - a.x, b.y - a.y)).toBeLessThanOrEqual(0.002);
    }
  });

  it('may be closed: a stroke that ends where it began keeps its shape', () => {
    const circle = Array.from({ length: 101 }, (_, i) => ({
      x: Math.cos((i * Math.PI) / 50),
      y: Math.sin((i * Math.PI) / 50),
    }));
    expect(simplify(circle, 0.01).length).toBeGreaterThan(12);
  });
});

describe('vertices without material', () => {
  /** The square without its four middle triangles round vertex 12, which comes to lie with vertex 0. */
  function withHole(): Surface {
    const mirror = squareMirror();
    const hole = 12;
    for (let slot = 0; slot < mirror.numSlots; ++slot) {
      const corners = mirror.triangles.subarray(3 * slot, 3 * slot + 3);
      if (corners.includes(hole)) corners.fill(-1);
    }
    mirror.positions.copyWithin(3 * hole, 0, 3);
    return new Surface(mirror);
  }

  it('are told from others, and the nearest other is found', () => {
    const surface = withHole();
    expect([11, 12, 13, 99].map((vertex) => surface.hasMaterial(vertex))).toEqual([true, false, true, false]);
    expect([7, 11, 13, 17]).toContain(surface.nearestWithMaterial(12));
    expect(surface.nearestWithMaterial(3)).toBe(3);
    // Undone: the next topology.
    const square = squareMirror();
    Object.assign(surface.mirror, { triangles: square.triangles, topologyVersion: 2 });
    expect(surface.hasMaterial(12)).toBe(true);
    expect(surface.nearestWithMaterial(12)).toBe(12);
  });

  it('are on no border, hit by no ray, at no place, and have no normal', () => {
    const surface = withHole();
    const { mirror } = surface;
    expect([...edgeSet(surface.boundary)].join(' ')).not.toMatch(/\b12\b/);
    expect(surface.locator.find({ x: 0.5, y: 0.5 })).toBeUndefined();
    expect(surface.pick(new Ray(new Vector3(2, 0.5, 9), new Vector3(0, 0, -1)))).toBeUndefined();
    const corner = surface.pick(new Ray(new Vector3(1.01, 0.005, 9), new Vector3(0, 0, -1)));
    expect(corner?.vertex).toBe(0);
    const normals = new Float32Array(3 * mirror.numVertices).fill(7);
    vertexNormals(mirror.positions, mirror.numVertices, mirror.triangles, mirror.numSlots, normals);
    for (let v = 0; v < mirror.numVertices; ++v) {
      expect([...normals.subarray(3 * v, 3 * v + 3)]).toEqual([0, 0, v === 12 ? 0 : 1]);
    }
  });
});
