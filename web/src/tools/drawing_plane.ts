import type { MessageInitShape } from '@bufbuild/protobuf';
import type { PerspectiveCamera } from 'three';
import { Vector2, Vector3 } from 'three';
import { View_Layers } from '../gen/kerf/v1/scene_pb';
import type { ViewSchema } from '../gen/kerf/v1/scene_pb';
import type { Point2 } from '../geometry/locator';
import type { Surface } from '../geometry/surface';
import type { Viewer } from './tool';

/**
 * The target of a cut: layers of the sheet as seen in the picture, or the material regardless of its place in the
 * world.
 */
export type CutTarget = 'seen' | 'all' | 'piece' | 'depth' | 'material';

/** Range of distances from the camera along its axis, metres. */
export interface DepthRange {
  nearestM: number;
  farthestM: number;
}

const kLayers: Record<Exclude<CutTarget, 'material'>, View_Layers> = {
  seen: View_Layers.NEAREST,
  all: View_Layers.ALL,
  piece: View_Layers.ONE_PIECE,
  depth: View_Layers.DEPTH_RANGE,
};

/**
 * Returns the view for a cut drawn on a picture of this size (CSS pixels) from the camera.
 * @param piece  label of the piece to cut; undefined: the piece seen where the curve first meets the sheet
 */
export function cutView(
  camera: PerspectiveCamera,
  sizePx: Vector2,
  target: Exclude<CutTarget, 'material'>,
  depth: DepthRange,
  piece?: number,
): MessageInitShape<typeof ViewSchema> {
  camera.updateMatrixWorld();
  return {
    view: [...camera.matrixWorldInverse.elements],
    projection: [...camera.projectionMatrix.elements],
    widthPx: sizePx.x,
    heightPx: sizePx.y,
    layers: kLayers[target],
    ...(target === 'depth' ? depth : {}),
    ...(target === 'piece' ? { piece } : {}),
  };
}

/** Returns the range of the half of the sheet nearer to the camera, in whole millimetres. */
export function frontHalf(surface: Surface, camera: PerspectiveCamera): DepthRange {
  const forward = camera.getWorldDirection(new Vector3());
  let [nearest, farthest] = [Infinity, 0];
  for (let v = 0; v < surface.mirror.numVertices; ++v) {
    const depth = surface.vertexPosition(v).sub(camera.position).dot(forward);
    [nearest, farthest] = [Math.min(nearest, depth), Math.max(farthest, depth)];
  }
  const nearestM = Math.max(0, Math.floor(1e3 * nearest) / 1e3);
  return { nearestM, farthestM: Math.max(nearestM, Math.ceil(500 * (nearest + farthest)) / 1e3) };
}

/** The plane on which a drawing lies. It converts between the drawing's coordinates and the canvas. */
export interface DrawingPlane {
  /** Returns the plane's point under a point of the canvas, CSS pixels. */
  at(px: Vector2): Point2 | undefined;
  toPx(point: Point2): Vector2 | undefined;
  /** Distance within which movements of the hand are unintentional, in the plane's unit. */
  readonly tremor: number;
}

const kTremorPx = 1.5;
// Tremor on the material, as a share of the sheet's diagonal.
const kTremorPart = 0.002;

/** The picture as a plane: the drawing stays in its place on the canvas while the sheet moves below it. */
export class PicturePlane implements DrawingPlane {
  readonly tremor = kTremorPx;

  at({ x, y }: Vector2): Point2 {
    return { x, y };
  }

  toPx({ x, y }: Point2): Vector2 {
    return new Vector2(x, y);
  }
}

/**
 * The material as a plane: the drawing moves with the sheet. A point beside the sheet keeps its distance to the nearest
 * border.
 */
export class MaterialPlane implements DrawingPlane {
  constructor(private readonly viewer: Pick<Viewer, 'shown' | 'stage'>) {}

  get tremor(): number {
    const { locator } = this.viewer.shown.surface ?? {};
    return locator ? kTremorPart * Math.hypot(locator.max.x - locator.min.x, locator.max.y - locator.min.y) : 0;
  }

  at(px: Vector2): Point2 | undefined {
    const { stage } = this.viewer;
    const { surface } = this.viewer.shown;
    return (
      surface?.pick(stage.rayAt(px))?.material ??
      surface?.pickBeside(px, stage.camera, stage.sizePx, (at) => stage.metresPerPx(at))
    );
  }

  toPx(point: Point2): Vector2 | undefined {
    const { stage } = this.viewer;
    const { surface } = this.viewer.shown;
    const world = surface?.toWorld(point);
    return world && stage.project(world);
  }
}
