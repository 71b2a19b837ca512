import { DoubleSide, MeshBasicMaterial } from 'three';
import type { DepthOffset } from './depth_offsets';

/** Draws nothing, and hides what is behind: for things that are in a picture of the server. */
export function hidingMaterial(offset: DepthOffset): MeshBasicMaterial {
  return new MeshBasicMaterial({ colorWrite: false, side: DoubleSide, ...offset });
}

/** Comes after all that lies over a picture whether it is hidden or not, such as pins. */
export const kHidingOrder = 1;
