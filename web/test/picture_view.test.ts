import { PerspectiveCamera, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { ColorBy } from '../src/gen/kerf/v1/render_pb';
import { pictureSize, pictureView } from '../src/scene/picture_view';

describe('pictureSize', () => {
  it('has the pixels of the canvas, an even number of them each way', () => {
    expect(pictureSize({ x: 1280, y: 720 }, 1)).toEqual({ widthPx: 1280, heightPx: 720 });
    expect(pictureSize({ x: 391, y: 303 }, 1)).toEqual({ widthPx: 390, heightPx: 302 });
    expect(pictureSize({ x: 390, y: 844 }, 1.5)).toEqual({ widthPx: 584, heightPx: 1266 });
  });

  it.each([
    [1920, 1080, 2],
    [3000, 800, 2],
    [5000, 100, 1],
    [100, 9000, 2],
    [2560, 1440, 1],
  ])('keeps the shape of %d x %d at %d within what the server draws', (x, y, ratio) => {
    const { widthPx, heightPx } = pictureSize({ x, y }, ratio);
    expect(Math.max(widthPx, heightPx)).toBeLessThanOrEqual(4096);
    expect(widthPx * heightPx).toBeLessThanOrEqual(1920 * 1200);
    expect(Math.abs(widthPx / x - heightPx / y)).toBeLessThanOrEqual(2 / Math.min(x, y));
    // As large as the limits let it be.
    const isAtLimit = Math.max(widthPx, heightPx) > 4090 || widthPx * heightPx > 0.99 * 1920 * 1200;
    expect(isAtLimit).toBe(true);
  });

  it('has a least side', () => {
    expect(pictureSize({ x: 400, y: 3 }, 1)).toEqual({ widthPx: 400, heightPx: 16 });
  });
});

describe('pictureView', () => {
  const size = { widthPx: 64, heightPx: 32 };
  const look = { wireframe: true, colorBy: ColorBy.PIECES, dark: true };

  it('looks as the camera does', () => {
    const camera = new PerspectiveCamera(36, 2);
    const target = new Vector3(0.5, 0.25, 0);
    camera.up.set(0, 0, 1);
    camera.position.set(1, -2, 3);
    camera.lookAt(target);
    const view = pictureView(camera, target, size, look);
    expect(view).toMatchObject({ ...size, ...look });
    expect(view.camera).toMatchObject({ eye: { x: 1, y: -2, z: 3 }, target: { x: 0.5, y: 0.25, z: 0 }, verticalFovDeg: 36 });
    // The light of pictures comes from there.
    expect(view.camera!.up).toEqual({ x: 0, y: 0, z: 1 });
  });
});
