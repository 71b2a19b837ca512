import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { CutSchema } from '../src/gen/kerf/v1/scene_pb';
import { PathSchema } from '../src/gen/kerf/v1/geometry_pb';
import { curveLines } from '../src/geometry/curve_lines';
import { LipRecord, lipsAlong } from '../src/geometry/lips';
import { SegmentGrid } from '../src/geometry/segment_grid';
import { Surface } from '../src/geometry/surface';
import { SheetMirror } from '../src/stream/mirror';

// A unit square of 4 x 1 squares, two triangles each. `cuts`: the lines x = i / 4 along which it is cut.
function strip(version: number, cuts: readonly number[]): Surface {
  const mirror = new SheetMirror();
  const material: number[] = [];
  const triangles: number[] = [];
  const column = (i: number) => {
    material.push(i / 4, 0, i / 4, 1);
    return material.length / 2 - 2;
  };
  let left = column(0);
  for (let i = 0; i < 4; ++i) {
    const right = column(i + 1);
    triangles.push(left, right, right + 1, left, right + 1, left + 1);
    left = cuts.includes(i + 1) ? column(i + 1) : right;
  }
  mirror.numVertices = material.length / 2;
  mirror.materialPositions = Float32Array.from(material);
  mirror.positions = new Float32Array(3 * mirror.numVertices);
  mirror.triangles = Int32Array.from(triangles);
  mirror.numSlots = triangles.length / 3;
  mirror.topologyVersion = version;
  return new Surface(mirror);
}

// Places x of the edges that a finder gives.
function places(surface: Surface, edges: Uint32Array | undefined): number[] {
  return [...(edges ?? [])].map((vertex) => surface.mirror.materialPositions[2 * vertex]);
}

describe('SegmentGrid', () => {
  it('has the points within reach of a segment, and no others', () => {
    const grid = new SegmentGrid(Float64Array.of(0, 0, 10, 5, 3, 3, 3, 3), 0.1);
    expect([grid.has(4, 2), grid.has(4, 2.1), grid.has(4, 2.13), grid.has(10.05, 5.05), grid.has(10.1, 5.1)]).toEqual([
      true,
      true,
      false,
      true,
      false,
    ]);
    expect([grid.has(3.05, 3.05), grid.has(3.1, 3.1)]).toEqual([true, false]);
  });

  it('is empty without segments', () => {
    expect(new SegmentGrid(new Float64Array(0), 0.1).has(0, 0)).toBe(false);
  });
});

describe('LipRecord', () => {
  it('knows both lips of a cut that it saw, still after another cut', () => {
    const record = new LipRecord();
    record.see(strip(1, []));
    record.see(strip(2, [2]));
    const after = strip(3, [1, 2]);
    record.see(after);
    expect(places(after, record.at(2)?.(after))).toEqual([0.5, 0.5, 0.5, 0.5]);
    expect(places(after, record.at(3)?.(after))).toEqual([0.25, 0.25, 0.25, 0.25]);
    expect(record.at(1)).toBeUndefined();
  });

  it('gives lips of all versions that came as one frame', () => {
    const record = new LipRecord();
    record.see(strip(1, []));
    const after = strip(3, [1, 2]);
    record.see(after);
    expect(places(after, record.at(2)?.(after))).toHaveLength(8);
    expect(record.at(2)?.(after)).toEqual(record.at(3)?.(after));
  });

  it('finds nothing where the cut was undone, and forgets all of another run of the server', () => {
    const record = new LipRecord();
    record.see(strip(1, []));
    record.see(strip(2, [2]));
    const undone = strip(3, []);
    record.see(undone);
    expect(places(undone, record.at(2)?.(undone))).toEqual([]);
    const other = strip(3, []);
    (other.mirror as SheetMirror).epoch = 'other';
    record.see(other);
    expect(record.at(2)).toBeUndefined();
  });
});

describe('lipsAlong', () => {
  const line = (x: number) => ({ kind: { case: 'polyline' as const, value: { points: [{ x, y: 0 }, { x, y: 1 }] } } });

  it('finds the lips along a curve on the material', () => {
    const surface = strip(2, [1, 2]);
    const find = lipsAlong(create(CutSchema, { curve: line(0.25) }), 1e-6);
    expect(places(surface, find?.(surface))).toEqual([0.25, 0.25, 0.25, 0.25]);
  });

  it('finds both sides of a strip', () => {
    const surface = strip(2, [1, 2]);
    const find = lipsAlong(create(CutSchema, { curve: line(0.375), widthM: 0.25 }), 1e-6);
    expect(new Set(places(surface, find?.(surface)))).toEqual(new Set([0.25, 0.5]));
  });

  it('knows nothing of a curve on a picture', () => {
    expect(lipsAlong(create(CutSchema, { curve: line(0.25), view: {} }), 1e-6)).toBeUndefined();
  });
});

describe('curveLines', () => {
  it('follows each kind of segment of a path, and closes it', () => {
    const path = create(PathSchema, {
      subpaths: [
        {
          start: { x: 0, y: 0 },
          segments: [
            { kind: { case: 'line', value: { x: 1, y: 0 } } },
            { kind: { case: 'quadratic', value: { control: { x: 2, y: 0 }, end: { x: 2, y: 1 } } } },
            { kind: { case: 'cubic', value: { control1: { x: 2, y: 2 }, control2: { x: 1, y: 2 }, end: { x: 1, y: 1 } } } },
            {
              kind: {
                case: 'arc',
                value: { semiAxisXM: 0.5, semiAxisYM: 0.5, counterClockwise: true, end: { x: 0, y: 1 } },
              },
            },
          ],
          closed: true,
        },
      ],
    });
    const [points] = curveLines({ kind: { case: 'path', value: path } }, 1e-3);
    const has = (x: number, y: number) => points.some((point) => Math.hypot(point.x - x, point.y - y) < 2e-3);
    expect([has(1, 0), has(1.75, 0.25), has(1.5, 1.75), has(0.5, 1.5)]).toEqual([true, true, true, true]);
    expect(points.at(-1)).toEqual(points[0]);
  });

  it('goes round an ellipse that is turned', () => {
    const ellipse = { center: { x: 1, y: 1 }, semiAxisXM: 2, semiAxisYM: 1, rotationRad: Math.PI / 2 };
    const { curve } = create(CutSchema, { curve: { kind: { case: 'ellipse', value: ellipse } } });
    const [points] = curveLines(curve!, 1e-3);
    const extent = (of: (point: { x: number; y: number }) => number) => [Math.min(...points.map(of)), Math.max(...points.map(of))];
    expect(extent(({ x }) => x).map((x) => Number(x.toFixed(6)))).toEqual([0, 2]);
    expect(extent(({ y }) => y).map((y) => Number(y.toFixed(6)))).toEqual([-1, 3]);
  });
});
