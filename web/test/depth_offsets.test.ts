import { describe, expect, it } from 'vitest';
import type { Material, Mesh } from 'three';
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
    expect(view.object.children).toHaveLength(4);
    for (const child of view.object.children) {
      const material = (child as Mesh).material as Material;
      expect(material.polygonOffset).toBe(true);
      expect(material.polygonOffsetFactor).toBeGreaterThan(2 * cloth.polygonOffsetFactor);
      expect(material.polygonOffsetUnits).toBeGreaterThan(2 * cloth.polygonOffsetUnits);
    }
  });
});
