import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { Region_Edge } from '../src/gen/kerf/v1/conditions_pb';
import { Fidelity } from '../src/gen/kerf/v1/scene_pb';
import { CreateSheetRequestSchema } from '../src/gen/kerf/v1/sheets_pb';
import { createRequest, formField, uploadPath } from '../src/ui/sheets/new_sheet';
import type { NewSheet } from '../src/ui/sheets/new_sheet';

const kGrid: NewSheet = {
  id: 'flag',
  shape: 'grid',
  columns: 30,
  rows: 20,
  widthM: 3,
  heightM: 2,
  file: undefined,
  mesh: { unitM: 1, up: 'z', object: '', ignoresTexture: false },
  outline: undefined,
  outlineWidthM: 1,
  hang: 'flat',
  material: 'silk',
  fidelity: Fidelity.EXACT,
  pins: Region_Edge.LEFT,
  hasFloor: true,
  hasBall: true,
  isPaused: true,
};

function made(form: Partial<NewSheet>) {
  const request = create(CreateSheetRequestSchema, createRequest({ ...kGrid, ...form }));
  return { request, scene: request.scene! };
}

describe('createRequest', () => {
  it('asks for the grid, its material and its pins', () => {
    const { request, scene } = made({});
    expect([request.sheetId, request.paused, scene.material?.preset]).toEqual(['flag', true, 'silk']);
    expect(scene.mesh).toMatchObject({ case: 'grid', value: { columns: 30, rows: 20, widthM: 3, heightM: 2 } });
    expect(scene.pins.map((pin) => pin.region)).toEqual([{ case: 'edge', value: Region_Edge.LEFT }]);
  });

  it.each(['grid', 'file', 'outline'] as const)('asks for the fidelity that was chosen, of a sheet by %s', (shape) => {
    expect(made({ shape }).scene.fidelity).toBe(Fidelity.EXACT);
    expect(made({ shape, fidelity: Fidelity.REAL_TIME }).scene.fidelity).toBe(Fidelity.REAL_TIME);
  });

  it('holds nothing where nothing is to be held', () => {
    expect(made({ pins: Region_Edge.EDGE_UNSPECIFIED }).scene.pins).toEqual([]);
  });

  it.each(['flat', 'upright'] as const)('hangs it %s, its middle over the origin, clear of floor and ball', (hang) => {
    const { scene } = made({ hang });
    const { origin, xAxis, yAxis } = scene.placement!;
    const at = (x: number, y: number) => ({
      x: origin!.x + x * xAxis!.x + y * yAxis!.x,
      y: origin!.y + x * xAxis!.y + y * yAxis!.y,
      z: origin!.z + x * xAxis!.z + y * yAxis!.z,
    });
    expect(at(1.5, 0).x).toBeCloseTo(0, 12);
    const [ball, floor] = scene.colliders.map((collider) => collider.shape);
    expect(floor.case).toBe('plane');
    const { center, radiusM } = ball.value as { center: { x: number; y: number; z: number }; radiusM: number };
    for (let x = 0; x <= 3; x += 0.25) {
      for (let y = 0; y <= 2; y += 0.25) {
        const point = at(x, y);
        expect(point.z).toBeGreaterThan(0);
        expect(Math.hypot(point.x - center.x, point.y - center.y, point.z - center.z)).toBeGreaterThan(radiusM);
      }
    }
  });

  it('sends a mesh file apart from the request, and neither places it nor guesses where a ball would be', () => {
    const content = new Blob(['v 0 0 0\n']);
    const file = { name: 'a.obj', kind: 'obj' as const, content };
    const { scene, request } = made({ shape: 'file', file });
    expect([scene.mesh.case, scene.placement]).toEqual(['obj', undefined]);
    expect(scene.colliders.map((collider) => collider.shape.case)).toEqual(['plane']);
    const query = new URLSearchParams(uploadPath(file, request).replace('/sheets?', ''));
    expect(query.get('format')).toBe('obj');
    expect(JSON.parse(query.get('request')!)).toMatchObject({ sheetId: 'flag', scene: { material: { preset: 'silk' } } });
  });

  it('lays a drawing, which begins at its upper left corner, above the floor', () => {
    const { scene } = made({ shape: 'outline', outline: { text: '<svg/>', heightM: 0.5 }, hang: 'upright' });
    expect(scene.mesh).toMatchObject({ case: 'outline' });
    // Its lowest point, half a metre below the origin of the material.
    expect(scene.placement!.origin!.z - 0.5).toBeCloseTo(0.3, 12);
  });

  it('cuts the holes of a drawing out of its border', () => {
    const curve = (text: string) => ({ kind: { case: 'svg', value: { text } } });
    const outline = { text: '<svg id="border"/>', holes: '<svg id="holes"/>', heightM: 0.5 };
    const { mesh } = made({ shape: 'outline', outline }).scene;
    expect(mesh.value).toMatchObject({ boundary: curve(outline.text), holes: [curve(outline.holes)] });
    const { mesh: plain } = made({ shape: 'outline', outline: { text: '<svg/>', heightM: 0.5 } }).scene;
    expect(plain.value).toMatchObject({ boundary: curve('<svg/>'), holes: [] });
  });
});

describe('formField', () => {
  it('finds where a field of the request is asked for', () => {
    expect(formField('scene.grid.columns')).toBe('columns');
    expect(formField('scene.obj.text')).toBe('file');
    expect(formField('start.num_bytes')).toBe('file');
    expect(formField('scene.outline.boundary')).toBe('outline');
    expect(formField('sheet_id')).toBe('id');
    expect(formField('scene.integrator')).toBeUndefined();
  });
});
