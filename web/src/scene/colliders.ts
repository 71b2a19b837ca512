import {
  BoxGeometry,
  CapsuleGeometry,
  Group,
  Mesh,
  MeshStandardMaterial,
  PlaneGeometry,
  Quaternion,
  SphereGeometry,
  Vector3,
} from 'three';
import type { BufferGeometry, Object3D } from 'three';
import type { Vec3 } from '../gen/kerf/v1/geometry_pb';
import type { Collider } from '../gen/kerf/v1/scene_pb';
import { GroundMaterial } from './ground_material';

// The sheet rests on a collider's surface: draw the solid a little smaller, so that cloth between two vertices that
// lies on a curved solid does not sink into it, and farther away, so that it does not show through where a pixel covers
// much of the surface. The factor is well above the cloth's own (cloth_material.ts), whose wrinkles are steeper than
// the solid; the units are 0.15 % of the first view's distance in a depth buffer of 24 bits, as in the server's pictures.
const kShrink = 0.985;
const kSolid = new MeshStandardMaterial({
  color: 0x9aa3ad,
  roughness: 0.6,
  metalness: 0.05,
  polygonOffset: true,
  polygonOffsetFactor: 4,
  polygonOffsetUnits: 256,
});

function vector(v: Vec3 | undefined): Vector3 {
  return new Vector3(v?.x ?? 0, v?.y ?? 0, v?.z ?? 0);
}

function solid(geometry: BufferGeometry, position: Vector3): Mesh {
  const mesh = new Mesh(geometry, kSolid);
  mesh.position.copy(position);
  mesh.castShadow = true;
  mesh.receiveShadow = true;
  return mesh;
}

function draw({ shape }: Collider, ground: GroundMaterial): Object3D | undefined {
  switch (shape.case) {
    case 'sphere':
      return solid(new SphereGeometry(kShrink * shape.value.radiusM, 64, 40), vector(shape.value.center));
    case 'box': {
      const half = vector(shape.value.halfExtentsM);
      const box = solid(new BoxGeometry(2 * half.x, 2 * half.y, 2 * half.z), vector(shape.value.center));
      const axis = vector(shape.value.axis);
      if (axis.lengthSq() > 0) box.quaternion.setFromAxisAngle(axis.normalize(), shape.value.angleRad);
      return box;
    }
    case 'capsule': {
      const [a, b] = [vector(shape.value.a), vector(shape.value.b)];
      const axis = b.clone().sub(a);
      const capsule = solid(
        new CapsuleGeometry(kShrink * shape.value.radiusM, axis.length(), 24, 48),
        a.clone().lerp(b, 0.5),
      );
      if (axis.lengthSq() > 0) capsule.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), axis.normalize());
      return capsule;
    }
    case 'plane': {
      const plane = new Mesh(new PlaneGeometry(1, 1), ground);
      plane.position.copy(vector(shape.value.point));
      plane.quaternion.copy(
        new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), vector(shape.value.normal).normalize()),
      );
      plane.scale.setScalar(2 * ground.reach);
      plane.receiveShadow = true;
      return plane;
    }
    default:
      return undefined;
  }
}

/** Draws the colliders of Sheet.scene. */
export class ColliderView {
  readonly object = new Group();

  constructor(private readonly ground: GroundMaterial) {}

  set(colliders: readonly Collider[]): void {
    for (const child of this.object.children) (child as Mesh).geometry.dispose();
    this.object.clear();
    for (const collider of colliders) {
      const object = draw(collider, this.ground);
      if (object) this.object.add(object);
    }
  }
}
