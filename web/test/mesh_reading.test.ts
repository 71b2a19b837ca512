import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { MeshReportSchema } from '../src/gen/kerf/v1/files_pb';
import { inspectPath, reportLines } from '../src/ui/sheets/mesh_reading';
import type { MeshChoices } from '../src/ui/sheets/mesh_reading';

const kChoices: MeshChoices = { unitM: 0.001, up: 'y', object: 'left', ignoresTexture: true };

describe('inspectPath', () => {
  const requestIn = (path: string) => JSON.parse(new URL(path, 'http://localhost').searchParams.get('request')!);

  it('says how the file is read', () => {
    const path = inspectPath({ name: 'a.obj', kind: 'obj', content: new Blob(['v 0 0 0\n']) }, kChoices);
    expect(path).toMatch(/^\/meshes\?format=obj&/);
    expect(requestIn(path)).toEqual({
      obj: { reading: { unitM: 0.001, upAxis: 'Y_UP', objects: ['left'], ignoreTextureCoordinates: true } },
    });
  });

  it('names no object for all of them', () => {
    const path = inspectPath({ name: 'a.ply', kind: 'ply', content: new Blob([]) }, { ...kChoices, object: '' });
    expect(requestIn(path).ply.reading.objects).toBeUndefined();
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
