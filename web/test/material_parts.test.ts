import { create } from '@bufbuild/protobuf';
import type { MessageInitShape } from '@bufbuild/protobuf';
import { describe, expect, it, vi } from 'vitest';
import { MaterialLine_Side } from '../src/gen/kerf/v1/conditions_pb';
import type { RegionSchema } from '../src/gen/kerf/v1/conditions_pb';
import { SheetSchema } from '../src/gen/kerf/v1/sheets_pb';
import type { Sheet } from '../src/gen/kerf/v1/sheets_pb';
import { MaterialParts } from '../src/geometry/material_parts';
import { kLooks } from '../src/scene/material_looks';
import { SheetLooks } from '../src/scene/sheet_looks';
import type { SheetArrays } from '../src/stream/sheet_copy';

type RegionShape = MessageInitShape<typeof RegionSchema>;

// A square of 4 x 4 squares, two triangles each; the lower left corner is at (x, 0), metres. The last slot is empty.
function square(x = 0): SheetArrays {
  const material: number[] = [];
  for (let i = 0; i < 25; ++i) material.push(x + (i % 5), Math.floor(i / 5));
  const triangles: number[] = [];
  for (let i = 0; i < 16; ++i) {
    const a = 5 * Math.floor(i / 4) + (i % 4);
    triangles.push(a, a + 1, a + 6, a, a + 6, a + 5);
  }
  triangles.push(-1, -1, -1);
  return {
    numVertices: 25,
    numSlots: 33,
    materialPositions: Float32Array.from(material),
    triangles: Int32Array.from(triangles),
    topologyVersion: 1,
  } as unknown as SheetArrays;
}

function sheetOf(regions: RegionShape[], components: Sheet['components'] = []): Sheet {
  const materials = regions.map((region) => ({ region, material: { preset: 'silk' } }));
  return create(SheetSchema, { name: 'sheets/a', scene: { materials }, components });
}

// Number of triangles of each part, from the sheet's own on.
function counts(regions: RegionShape[], mesh = square(), components: Sheet['components'] = []): number[] {
  const parts = new MaterialParts(sheetOf(regions, components)).ofTriangles(mesh);
  expect(parts[32]).toBe(0);
  return Array.from({ length: regions.length + 1 }, (_, part) => parts.subarray(0, 32).filter((each) => each === part).length);
}

const box = (x0: number, y0: number, x1: number, y1: number): RegionShape['region'] => ({
  case: 'box',
  value: { min: { x: x0, y: y0 }, max: { x: x1, y: y1 } },
});

describe('MaterialParts', () => {
  it('have the triangles whose centroid they hold, a later part over those before', () => {
    expect(counts([{ region: box(0, 0, 2, 4) }])).toEqual([16, 16]);
    expect(counts([{ region: box(0, 0, 2, 4) }, { region: box(1, 0, 4, 1) }])).toEqual([12, 14, 6]);
    expect(counts([{ region: { case: 'all', value: true } }])).toEqual([0, 32]);
    expect(counts([{ region: { case: 'nearest', value: {} } }])).toEqual([32, 0]);
  });

  it('follow lines and curves, and their sides', () => {
    const line = (side: MaterialLine_Side): RegionShape => ({
      region: { case: 'line', value: { a: { x: 2, y: 0 }, b: { x: 2, y: 4 }, withinM: 1, side } },
    });
    expect(counts([line(MaterialLine_Side.BOTH)])).toEqual([16, 16]);
    expect(counts([line(MaterialLine_Side.LEFT_OF_LINE)])).toEqual([24, 8]);
    const circle = (side: MaterialLine_Side): RegionShape => ({
      region: {
        case: 'curve',
        value: { curve: { kind: { case: 'circle', value: { center: { x: 2, y: 2 }, radiusM: 1.6 } } }, withinM: 4, side },
      },
    });
    const [outside, inside] = counts([circle(MaterialLine_Side.LEFT_OF_LINE)]);
    expect(inside).toBe(16);
    expect(counts([circle(MaterialLine_Side.RIGHT_OF_LINE)])).toEqual([inside, outside]);
  });

  it('of listed vertices stay where they were when a cut changes the mesh', () => {
    const mesh = square();
    const vertices = [0, 1, 5, 6];
    const parts = new MaterialParts(sheetOf([{ region: { case: 'vertices', value: { vertices } } }]));
    expect([...parts.ofTriangles(mesh)].flatMap((part, slot) => (part === 1 ? [slot] : []))).toEqual([0, 1]);
    // A vertex in the middle of the first square replaces its upper left triangle by two.
    const triangles = Int32Array.from(mesh.triangles);
    triangles.set([0, 6, 25], 3);
    triangles.set([6, 5, 25], 96);
    const cut = { ...mesh, numVertices: 26, triangles, materialPositions: Float32Array.of(...mesh.materialPositions, 0.4, 0.6) };
    expect([...parts.ofTriangles(cut)].flatMap((part, slot) => (part === 1 ? [slot] : []))).toEqual([0, 1, 32]);
  });

  it('of a component are in its own coordinates, and end where it ends', () => {
    const components = [
      { name: 'left', offset: { x: 0, y: 0 }, extent: { min: { x: 0, y: 0 }, max: { x: 4, y: 4 } } },
      { name: 'right', offset: { x: 10, y: 0 }, extent: { min: { x: 0, y: 0 }, max: { x: 4, y: 4 } } },
    ].map((each) => ({ ...each, firstVertex: 0, numVertices: 25 }) as unknown as Sheet['components'][number]);
    const part = (component: string): RegionShape => ({ component, region: box(0, 0, 1, 4) });
    expect(counts([part('right')], square(10), components)).toEqual([24, 8]);
    expect(counts([part('left')], square(10), components)).toEqual([32, 0]);
    expect(counts([{ component: 'left', region: { case: 'all', value: true } }], square(10), components)).toEqual([32, 0]);
  });
});

describe('SheetLooks', () => {
  const silk = { youngsModulusPa: 8.0e7, thicknessM: 1.2e-4, densityKgpm3: 420 };
  const rubber = { youngsModulusPa: 1.5e6, thicknessM: 1.0e-3, densityKgpm3: 950 };
  const sheet = (own: object, ofBox: object) =>
    create(SheetSchema, {
      name: 'sheets/a',
      scene: { material: own, materials: [{ region: { region: box(0, 0, 2, 4) }, material: ofBox }] },
    });

  it('give each part its look, and ask for the triangles again when another look is there', () => {
    const [looks, setLooks] = [new SheetLooks(), vi.fn()];
    const shown = () => setLooks.mock.calls.at(-1)!;
    looks.show(sheet(silk, rubber), { setLooks });
    expect(shown()[0]).toEqual([kLooks.silk, kLooks.rubber]);
    const [, finder] = shown();
    expect(finder(square()).filter((look: number) => look === 1).length).toBe(16);
    looks.show(sheet({ ...silk, youngsModulusPa: 8.1e7 }, rubber), { setLooks });
    expect(shown()[1]).toBe(finder);
    looks.show(sheet(rubber, rubber), { setLooks });
    expect(shown()[0]).toEqual([kLooks.rubber]);
    expect(shown()[1](square())).toBeUndefined();
  });
});
