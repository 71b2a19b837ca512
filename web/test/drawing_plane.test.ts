import { create } from '@bufbuild/protobuf';
import { Matrix4, PerspectiveCamera, Vector2, Vector3, Vector4 } from 'three';
import { describe, expect, it } from 'vitest';
import { ViewSchema, View_Layers } from '../src/gen/kerf/v1/scene_pb';
import { PicturePlane, cutView } from '../src/tools/drawing_plane';

const kSize = new Vector2(1280, 720);

function camera(): PerspectiveCamera {
  const made = new PerspectiveCamera(36, kSize.x / kSize.y, 0.01, 100);
  made.up.set(0, 0, 1);
  made.position.set(1, -2, 1.5);
  made.lookAt(0.1, 0.2, 0.3);
  return made;
}

describe('cutView', () => {
  it('is a view through which the server sees each point in the pixel where the canvas shows it', () => {
    const from = camera();
    const view = create(ViewSchema, cutView(from, kSize, 'seen', { nearestM: 0, farthestM: 0 }));
    expect(view.layers).toBe(View_Layers.NEAREST);
    for (const world of [new Vector3(0, 0, 0), new Vector3(0.4, -0.3, 0.8), new Vector3(-0.2, 0.5, 0.1)]) {
      // As view.proto says: column by column, world -> camera -> clip, pixel (0, 0) top left, y down.
      const clip = new Vector4(world.x, world.y, world.z, 1)
        .applyMatrix4(new Matrix4().fromArray(view.view))
        .applyMatrix4(new Matrix4().fromArray(view.projection));
      const px = new Vector2(
        (0.5 + (0.5 * clip.x) / clip.w) * view.widthPx,
        (0.5 - (0.5 * clip.y) / clip.w) * view.heightPx,
      );
      const shown = world.clone().project(from);
      const expected = new Vector2((0.5 + 0.5 * shown.x) * kSize.x, (0.5 - 0.5 * shown.y) * kSize.y);
      expect(px.distanceTo(expected)).toBeLessThan(1e-6);
      expect(new PicturePlane().at(expected)).toEqual({ x: expected.x, y: expected.y });
    }
  });

  it('has a rotation and a shift for its view, also when the camera has just moved', () => {
    const from = camera();
    from.position.x += 1;
    const { view } = create(ViewSchema, cutView(from, kSize, 'all', { nearestM: 0, farthestM: 0 }));
    const rotation = new Matrix4().fromArray(view);
    expect(new Vector3(2, -2, 1.5).applyMatrix4(rotation).length()).toBeLessThan(1e-12);
    expect(rotation.determinant()).toBeCloseTo(1, 12);
  });

  it('has the piece only where one is cut', () => {
    const piece = (target: 'seen' | 'piece', label?: number) =>
      create(ViewSchema, cutView(camera(), kSize, target, { nearestM: 0, farthestM: 0 }, label)).piece;
    expect([piece('piece', 0), piece('piece', 3), piece('piece'), piece('seen', 3)]).toEqual([0, 3, undefined, undefined]);
  });

  it('has depths only where they choose the layers', () => {
    const depth = { nearestM: 1, farthestM: 2 };
    const layers = (target: 'seen' | 'all' | 'piece' | 'depth') => {
      const view = create(ViewSchema, cutView(camera(), kSize, target, depth));
      return [view.layers, view.nearestM, view.farthestM];
    };
    expect(layers('depth')).toEqual([View_Layers.DEPTH_RANGE, 1, 2]);
    expect(layers('piece')).toEqual([View_Layers.ONE_PIECE, 0, 0]);
    expect(layers('all')).toEqual([View_Layers.ALL, 0, 0]);
  });
});
