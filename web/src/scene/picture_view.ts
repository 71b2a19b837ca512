import type { PerspectiveCamera, Vector2, Vector3 } from 'three';
import type { ColorBy } from '../gen/kerf/v1/render_pb';
import type { ImageView } from '../stream/image_watch';

// Limits of kerf.v1.ImageView: the sides of a picture, and for VP8 its number of pixels.
const kMaxSidePx = 4096;
const kMinSidePx = 16;
const kMaxVideoPx = 1920 * 1200;

export interface PictureSize {
  widthPx: number;
  heightPx: number;
}

/**
 * Returns the size of a picture that fills a canvas: its pixels, or fewer in the same proportions if the server does
 * not draw as many. Both sides are even, because video halves the resolution of colours.
 * @param canvas  CSS pixels
 * @param ratio   pixels per CSS pixel
 */
export function pictureSize({ x, y }: Pick<Vector2, 'x' | 'y'>, ratio: number): PictureSize {
  const fits = Math.min(1, kMaxSidePx / (ratio * Math.max(x, y)), Math.sqrt(kMaxVideoPx / (ratio * ratio * x * y)));
  const even = (length: number) => Math.max(kMinSidePx, 2 * Math.floor((ratio * fits * length) / 2));
  return { widthPx: even(x), heightPx: even(y) };
}

/** Returns the view of a sheet from a camera that looks at `target`. */
export function pictureView(
  camera: PerspectiveCamera,
  target: Vector3,
  size: PictureSize,
  look: { wireframe: boolean; colorBy: ColorBy; dark: boolean },
): ImageView {
  const vector = ({ x, y, z }: Vector3) => ({ x, y, z });
  return {
    ...size,
    ...look,
    camera: {
      eye: vector(camera.position),
      target: vector(target),
      // The world's up, not the view's, because the light comes from it.
      up: vector(camera.up),
      verticalFovDeg: camera.fov,
    },
  };
}
