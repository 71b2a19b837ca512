import { create } from '@bufbuild/protobuf';
import { Mesh, MeshBasicMaterial } from 'three';
import { expect, it } from 'vitest';
import { ColliderSchema } from '../src/gen/kerf/v1/scene_pb';
import { ColliderView } from '../src/scene/colliders';
import { GroundMaterial } from '../src/scene/ground_material';

it('solids that are not drawn hide what is behind them where that is wanted, and floors never do', () => {
  const view = new ColliderView(new GroundMaterial());
  view.set([
    create(ColliderSchema, { shape: { case: 'sphere', value: { center: { x: 1, y: 2, z: 3 }, radiusM: 0.5 } } }),
    create(ColliderSchema, { shape: { case: 'plane', value: { point: {}, normal: { z: 1 } } } }),
  ]);
  const seen = () => {
    const found: Mesh[] = [];
    view.object.traverseVisible((object) => void (object instanceof Mesh && found.push(object)));
    return found;
  };
  expect(seen().length).toBe(2);
  view.setDrawn(false);
  expect(seen()).toEqual([]);
  view.setHiding(true);
  const [mask, ...others] = seen();
  expect(others).toEqual([]);
  expect(mask.position.toArray()).toEqual([1, 2, 3]);
  const { colorWrite, depthWrite } = mask.material as MeshBasicMaterial;
  expect([colorWrite, depthWrite]).toEqual([false, true]);
});
