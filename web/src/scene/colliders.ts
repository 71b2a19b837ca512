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
import type { BufferGeometry } from 'three';
import type { Vec3 } from '../gen/kerf/v1/geometry_pb';
import type { Collider } from '../gen/kerf/v1/scene_pb';
import { kSupportOffset } from './depth_offsets';
import { GroundMaterial } from './ground_material';
import { hidingMaterial, kHidingOrder } from './hiding_material';

// Curved solids are drawn smaller by this factor, so that cloth between two vertices resting on them does not seem to
// sink in.
const kShrink = 0.985;
const kSolid = new MeshStandardMaterial({
  color: 0x9aa3ad,
  roughness: 0.6,
  metalness: 0.05,
  ...kSupportOffset,
});

const kMask = hidingMaterial(kSupportOffset);

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

function draw({ shape }: Collider, ground: GroundMaterial): Mesh | undefined {
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

function mask(drawn: Mesh): Mesh {
  const made = new Mesh(drawn.geometry, kMask);
  made.position.copy(drawn.position);
  made.quaternion.copy(drawn.quaternion);
  made.renderOrder = kHidingOrder;
  return made;
}

/** Draws the colliders of Sheet.scene. */
export class ColliderView {
  readonly object = new Group();
  private readonly drawn = new Group();
  private readonly masks = new Group();

  constructor(private readonly ground: GroundMaterial) {
    this.object.add(this.drawn, this.masks);
    this.masks.visible = false;
  }

  setDrawn(isDrawn: boolean): void {
    this.drawn.visible = isDrawn;
  }

  /** Sets whether solids that are not drawn still hide what is behind them. */
  setHiding(isHiding: boolean): void {
    this.masks.visible = isHiding;
  }

  set(colliders: readonly Collider[]): void {
    for (const child of this.drawn.children) (child as Mesh).geometry.dispose();
    this.drawn.clear();
    this.masks.clear();
    for (const collider of colliders) {
      const object = draw(collider, this.ground);
      if (!object) continue;
      this.drawn.add(object);
      if (object.material === kSolid) this.masks.add(mask(object));
    }
  }
}
