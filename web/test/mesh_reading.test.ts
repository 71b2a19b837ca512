import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { InspectMeshRequestSchema, MeshReportSchema } from '../src/gen/kerf/v1/files_pb';
import { MeshReading_UpAxis } from '../src/gen/kerf/v1/scene_pb';
import { inspectRequest, reportLines } from '../src/ui/sheets/mesh_reading';
import type { MeshChoices } from '../src/ui/sheets/mesh_reading';

const kChoices: MeshChoices = { unitM: 0.001, up: 'y', object: 'left', ignoresTexture: true };

describe('inspectRequest', () => {
  it('has the file and how it is read', async () => {
    const file = { name: 'a.obj', kind: 'obj' as const, content: new Blob(['v 0 0 0\n']) };
    const { mesh } = create(InspectMeshRequestSchema, await inspectRequest(file, kChoices));
    expect(mesh).toMatchObject({ case: 'obj', value: { text: 'v 0 0 0\n' } });
    expect((mesh.value as { reading?: unknown }).reading).toMatchObject({
      unitM: 0.001,
      upAxis: MeshReading_UpAxis.Y_UP,
      objects: ['left'],
      ignoreTextureCoordinates: true,
    });
  });

  it('has the bytes of a PLY file, and no object for all of them', async () => {
    const file = { name: 'a.ply', kind: 'ply' as const, content: new Blob([new Uint8Array([112, 255])]) };
    const { mesh } = create(InspectMeshRequestSchema, await inspectRequest(file, { ...kChoices, object: '' }));
    expect(mesh.case).toBe('ply');
    expect([...(mesh.value as { data: Uint8Array }).data]).toEqual([112, 255]);
    expect((mesh.value as { reading?: { objects: string[] } }).reading!.objects).toEqual([]);
  });
});

describe('reportLines', () => {
  it('describes the sheet, then notes', () => {
    const report = create(MeshReportSchema, {
      numVertices: 63,
      numTriangles: 96,
      pieces: 1,
      flat: true,
      extent: { min: { x: 0, y: 0, z: 0 }, max: { x: 0.4, y: 0.05, z: 0 } },
      notes: ['joined 288 vertices'],
    });
    expect(reportLines(report)).toEqual([
      { kind: 'fact', text: 'A flat sheet of 0.4 m × 50 mm × 0 mm: 63 vertices, 96 triangles' },
      { kind: 'note', text: 'joined 288 vertices' },
    ]);
  });

  it('lists faults of a file that makes no sheet', () => {
    const report = create(MeshReportSchema, { format: 'OBJ', faults: ['face 1 (line 5) crosses itself'] });
    expect(reportLines(report)).toEqual([{ kind: 'fault', text: 'face 1 (line 5) crosses itself' }]);
  });
});
