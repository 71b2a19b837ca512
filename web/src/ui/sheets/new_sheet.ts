import type { MessageInitShape } from '@bufbuild/protobuf';
import { requestBody } from '../../api';
import { Region_Edge } from '../../gen/kerf/v1/conditions_pb';
import type { CurveSchema } from '../../gen/kerf/v1/geometry_pb';
import type { ColliderSchema, Fidelity, PlacementSchema, SceneSchema } from '../../gen/kerf/v1/scene_pb';
import { CreateSheetRequestSchema } from '../../gen/kerf/v1/sheets_pb';
import { readingOf } from './mesh_reading';
import type { MeshChoices, MeshFile } from './mesh_reading';

export type NewShape = 'grid' | 'file' | 'outline';
export type Hang = 'upright' | 'flat';

/** A drawing with its size: see scaledOutline(). */
export interface Outline {
  /** SVG text of the border. */
  text: string;
  /** SVG text of all holes, on the same page; undefined without holes. */
  holes?: string;
  /** metres */
  heightM: number;
}

/** Values of the form. Lengths in metres. */
export interface NewSheet {
  id: string;
  shape: NewShape;
  columns: number;
  rows: number;
  widthM: number;
  heightM: number;
  file: MeshFile | undefined;
  mesh: MeshChoices;
  outline: Outline | undefined;
  outlineWidthM: number;
  hang: Hang;
  material: string;
  fidelity: Fidelity;
  /** Pinned edge; EDGE_UNSPECIFIED: nothing is held. */
  pins: Region_Edge;
  hasFloor: boolean;
  hasBall: boolean;
  isPaused: boolean;
}

type Mesh = MessageInitShape<typeof SceneSchema>['mesh'];

const kBallFriction = 0.4;
const kFloorFriction = 0.5;
// Radius of the ball, as a share of the sheet's smaller side.
const kBallRadius = 0.25;
// Shares of the sheet's larger side: height of a flat sheet, height of the lower edge of an upright one above the
// floor, and gap between sheet and ball.
const kFlatHeight = 0.8;
const kUprightHeight = 0.3;
const kBallGap = 0.08;

// The content of a mesh file is not part of the request: see uploadPath().
function meshOf({ shape, columns, rows, widthM, heightM, outline, file, mesh }: NewSheet): Mesh {
  if (shape === 'file') return file ? { case: file.kind, value: { reading: readingOf(mesh) } } : { case: undefined };
  if (shape === 'grid') return { case: 'grid', value: { columns, rows, widthM, heightM } };
  const holes = outline?.holes === undefined ? [] : [svgCurve(outline.holes)];
  return { case: 'outline', value: { boundary: svgCurve(outline?.text ?? ''), holes } };
}

function svgCurve(text: string): MessageInitShape<typeof CurveSchema> {
  return { kind: { case: 'svg', value: { text } } };
}

// Size of the sheet, and y of its lower edge: a drawing has its upper left corner at the origin, a grid its lower left
// one.
function extent(form: NewSheet): { width: number; height: number; bottom: number } {
  if (form.shape === 'grid') return { width: form.widthM, height: form.heightM, bottom: 0 };
  const height = form.outline?.heightM ?? 0;
  return { width: form.outlineWidthM, height, bottom: -height };
}

// Places the sheet above the floor at z = 0, its middle above the origin. A mesh file has its own place.
function placementOf(form: NewSheet): MessageInitShape<typeof PlacementSchema> | undefined {
  if (form.shape === 'file') return undefined;
  const { width, height, bottom } = extent(form);
  const larger = Math.max(width, height);
  const xAxis = { x: 1, y: 0, z: 0 };
  if (form.hang === 'flat') {
    const origin = { x: -0.5 * width, y: -0.5 * height - bottom, z: kFlatHeight * larger };
    return { origin, xAxis, yAxis: { x: 0, y: 1, z: 0 } };
  }
  const origin = { x: -0.5 * width, y: 0, z: kUprightHeight * larger - bottom };
  return { origin, xAxis, yAxis: { x: 0, y: 0, z: 1 } };
}

function ballOf(form: NewSheet): MessageInitShape<typeof ColliderSchema> {
  const { width, height } = extent(form);
  const larger = Math.max(width, height);
  const radiusM = kBallRadius * Math.min(width, height);
  const gap = kBallGap * larger;
  const center =
    form.hang === 'flat'
      ? { x: 0, y: 0, z: kFlatHeight * larger - radiusM - gap }
      : { x: 0, y: radiusM + gap, z: kUprightHeight * larger + 0.4 * height };
  return { shape: { case: 'sphere', value: { center, radiusM } }, friction: kBallFriction };
}

function collidersOf(form: NewSheet): MessageInitShape<typeof ColliderSchema>[] {
  const plane = { point: {}, normal: { z: 1 } };
  return [
    ...(form.hasBall && form.shape !== 'file' ? [ballOf(form)] : []),
    ...(form.hasFloor ? [{ shape: { case: 'plane' as const, value: plane }, friction: kFloorFriction }] : []),
  ];
}

/** Returns the request that creates the sheet. The server refuses values out of range, naming the field. */
export function createRequest(form: NewSheet): MessageInitShape<typeof CreateSheetRequestSchema> {
  const pins =
    form.pins === Region_Edge.EDGE_UNSPECIFIED ? [] : [{ region: { case: 'edge' as const, value: form.pins } }];
  return {
    sheetId: form.id,
    paused: form.isPaused,
    scene: {
      mesh: meshOf(form),
      material: { preset: form.material },
      fidelity: form.fidelity,
      placement: placementOf(form),
      pins,
      colliders: collidersOf(form),
    },
  };
}

/**
 * Returns the path to which a mesh file is sent, with the other values in the query. The file may be larger than a
 * request.
 */
export function uploadPath(file: MeshFile, request: MessageInitShape<typeof CreateSheetRequestSchema>): string {
  const body = requestBody(CreateSheetRequestSchema, request);
  return `/sheets?format=${file.kind}&request=${encodeURIComponent(body)}`;
}

/** Returns the form's field for a field of the request; undefined if there is none. */
export function formField(path: string): string | undefined {
  const fields: [RegExp, string][] = [
    [/^sheet_id|^scene\.sheet_id/, 'id'],
    [/^scene\.grid\.columns/, 'columns'],
    [/^scene\.grid\.rows/, 'rows'],
    [/^scene\.grid\.width_m/, 'width'],
    [/^scene\.grid\.height_m/, 'height'],
    [/^scene\.(obj|ply)|^start\.num_bytes/, 'file'],
    [/^scene\.outline/, 'outline'],
    [/^scene\.material/, 'material'],
    [/^scene\.pins/, 'pins'],
  ];
  return fields.find(([pattern]) => pattern.test(path))?.[1];
}
