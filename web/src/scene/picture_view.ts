import type { PerspectiveCamera, Vector2, Vector3 } from 'three';
import type { ColorBy } from '../gen/kerf/v1/render_pb';
import type { ImageView } from '../stream/image_watch';

// kerf.v1.ImageView: sides, and of VP8 the pixels of a picture.
const kMaxSidePx = 4096;
const kMinSidePx = 16;
const kMaxVideoPx = 1920 * 1200;

export interface PictureSize {
  widthPx: number;
  heightPx: number;
}

/**
 * Size of a picture that fills a canvas: as many pixels as it has, or where those are more than the server draws, fewer of the
 * same shape. Even, for video halves colours.
 * @param canvas  CSS pixels
 * @param ratio   pixels a CSS pixel
 */
export function pictureSize({ x, y }: Pick<Vector2, 'x' | 'y'>, ratio: number): PictureSize {
  const fits = Math.min(1, kMaxSidePx / (ratio * Math.max(x, y)), Math.sqrt(kMaxVideoPx / (ratio * ratio * x * y)));
  const even = (length: number) => Math.max(kMinSidePx, 2 * Math.floor((ratio * fits * length) / 2));
  return { widthPx: even(x), heightPx: even(y) };
}

/** View of a sheet from a camera that looks at `target`. */
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
      // Not the camera's own: the light comes from where up is.
      up: vector(camera.up),
      verticalFovDeg: camera.fov,
    },
  };
}
