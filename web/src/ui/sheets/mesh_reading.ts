import type { MessageInitShape } from '@bufbuild/protobuf';
import { requestBody } from '../../api';
import { InspectMeshRequestSchema } from '../../gen/kerf/v1/files_pb';
import type { MeshReport } from '../../gen/kerf/v1/files_pb';
import { MeshReading_UpAxis } from '../../gen/kerf/v1/scene_pb';
import type { MeshReadingSchema } from '../../gen/kerf/v1/scene_pb';
import { countText } from '../../tools/cut_text';

export interface MeshFile {
  name: string;
  kind: 'obj' | 'ply';
  content: Blob;
}

/** Values of the form that say how a mesh file is read. */
export interface MeshChoices {
  /** metres of a unit of the file */
  unitM: number;
  up: 'x' | 'y' | 'z';
  /** name of the only object or group that is read; empty: all */
  object: string;
  ignoresTexture: boolean;
}

const kUpAxes = { x: MeshReading_UpAxis.X_UP, y: MeshReading_UpAxis.Y_UP, z: MeshReading_UpAxis.Z_UP };

export function readingOf(choices: MeshChoices): MessageInitShape<typeof MeshReadingSchema> {
  return {
    unitM: choices.unitM,
    upAxis: kUpAxes[choices.up],
    objects: choices.object === '' ? [] : [choices.object],
    ignoreTextureCoordinates: choices.ignoresTexture,
  };
}

/** Returns the path to which a mesh file is sent to be described. The file may be larger than a request. */
export function inspectPath(file: MeshFile, choices: MeshChoices): string {
  const mesh = { case: file.kind, value: { reading: readingOf(choices) } };
  const body = requestBody(InspectMeshRequestSchema, { mesh } as MessageInitShape<typeof InspectMeshRequestSchema>);
  return `/meshes?format=${file.kind}&request=${encodeURIComponent(body)}`;
}

/** A line about a mesh file. */
export interface ReportLine {
  kind: 'fact' | 'note' | 'fault';
  text: string;
}

function sizeOf(metres: number): string {
  return metres < 0.1 ? `${Number((1e3 * metres).toPrecision(3))} mm` : `${Number(metres.toPrecision(3))} m`;
}

/** Describes a mesh file: the sheet that it makes, what was mended, and what keeps it from being one. */
export function reportLines(report: MeshReport): ReportLine[] {
  const lines: ReportLine[] = [];
  if (report.numVertices > 0) {
    const { min, max } = report.extent!;
    const sides = [max!.x - min!.x, max!.y - min!.y, max!.z - min!.z].map(sizeOf);
    const parts = report.pieces > 1 ? `, ${countText(report.pieces, 'piece')}` : '';
    const shape = report.flat ? 'flat' : 'curved';
    const counts = `${countText(report.numVertices, 'vertex', 'vertices')}, ${countText(report.numTriangles, 'triangle')}`;
    lines.push({ kind: 'fact', text: `A ${shape} sheet of ${sides.join(' × ')}: ${counts}${parts}` });
  }
  lines.push(...report.notes.map((text) => ({ kind: 'note' as const, text })));
  lines.push(...report.faults.map((text) => ({ kind: 'fault' as const, text })));
  return lines;
}
