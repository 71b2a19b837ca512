import { Box3, Vector3 } from 'three';
import type { Vec3 } from '../gen/kerf/v1/geometry_pb';
import type { Collider } from '../gen/kerf/v1/scene_pb';
import type { SheetArrays } from '../stream/sheet_copy';

function vector(v: Vec3 | undefined): Vector3 {
  return new Vector3(v?.x ?? 0, v?.y ?? 0, v?.z ?? 0);
}

function expand(box: Box3, center: Vector3, reach: number): void {
  box.union(new Box3(center.clone().subScalar(reach), center.clone().addScalar(reach)));
}

/** Returns the box around the sheet and all bounded colliders (not planes), metres. */
export function worldBox(mirror: SheetArrays, colliders: readonly Collider[]): Box3 {
  const box = new Box3();
  const at = new Vector3();
  for (let v = 0; v < mirror.numVertices; ++v) box.expandByPoint(at.fromArray(mirror.positions, 3 * v));
  for (const { shape } of colliders) {
    if (shape.case === 'sphere') expand(box, vector(shape.value.center), shape.value.radiusM);
    if (shape.case === 'box') expand(box, vector(shape.value.center), vector(shape.value.halfExtentsM).length());
    if (shape.case === 'capsule') {
      expand(box, vector(shape.value.a), shape.value.radiusM);
      expand(box, vector(shape.value.b), shape.value.radiusM);
    }
  }
  return box;
}
