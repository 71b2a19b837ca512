import { DoubleSide, MeshBasicMaterial } from 'three';
import type { DepthOffset } from './depth_offsets';

/**
 * Returns a material that draws nothing but hides what is behind. It stands for things that a picture of the server
 * shows.
 */
export function hidingMaterial(offset: DepthOffset): MeshBasicMaterial {
  return new MeshBasicMaterial({ colorWrite: false, side: DoubleSide, ...offset });
}

/** Render order of hiding materials: after all that lies over a picture and is never hidden, such as pins. */
export const kHidingOrder = 1;
