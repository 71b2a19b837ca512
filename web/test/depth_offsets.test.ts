import { describe, expect, it } from 'vitest';
import { Mesh } from 'three';
import type { Material } from 'three';
import { create } from '@bufbuild/protobuf';
import { ColliderSchema } from '../src/gen/kerf/v1/scene_pb';
import { ClothMaterial } from '../src/scene/cloth_material';
import { ColliderView } from '../src/scene/colliders';
import { GroundMaterial } from '../src/scene/ground_material';

describe('depth offsets', () => {
  it('keep the cloth in front of all that it can rest on', () => {
    const view = new ColliderView(new GroundMaterial());
    view.set([
      create(ColliderSchema, { shape: { case: 'sphere', value: { radiusM: 1 } } }),
      create(ColliderSchema, { shape: { case: 'box', value: { halfExtentsM: { x: 1, y: 1, z: 1 } } } }),
      create(ColliderSchema, { shape: { case: 'capsule', value: { a: {}, b: { z: 1 }, radiusM: 1 } } }),
      create(ColliderSchema, { shape: { case: 'plane', value: { normal: { z: 1 } } } }),
    ]);
    const cloth = new ClothMaterial();
    const meshes: Mesh[] = [];
    view.object.traverse((object) => void (object instanceof Mesh && meshes.push(object)));
    // Each of the solids is there once more, to hide what is behind it.
    expect(meshes).toHaveLength(4 + 3);
    for (const mesh of meshes) {
      const material = mesh.material as Material;
      expect(material.polygonOffset).toBe(true);
      expect(material.polygonOffsetFactor).toBeGreaterThan(2 * cloth.polygonOffsetFactor);
      expect(material.polygonOffsetUnits).toBeGreaterThan(2 * cloth.polygonOffsetUnits);
    }
  });
});
