/** A shift in depth, away from the viewer, with which a material is drawn. */
export interface DepthOffset {
  polygonOffset: true;
  polygonOffsetFactor: number;
  polygonOffsetUnits: number;
}

/** Draws the cloth behind the lips and wires on it, and in front of the solids and floors that it rests on. */
export const kClothOffset: DepthOffset = { polygonOffset: true, polygonOffsetFactor: 1.5, polygonOffsetUnits: 2 };

/**
 * Draws solids and floors behind the cloth that rests on them, also where a pixel covers much of a surface. The factor
 * is well above the cloth's own, whose wrinkles are steeper than the solid. In a depth buffer of 24 bits the units
 * shift by 0.15 % of the first view's distance, as in the server's pictures.
 */
export const kSupportOffset: DepthOffset = { polygonOffset: true, polygonOffsetFactor: 4, polygonOffsetUnits: 256 };

/**
 * Draws drawings on the cloth nearer than the cloth, by 0.6 % of the first view's distance. Wide lines on slopes are
 * thus hidden only by folds, not by the cloth that they lie on.
 */
export const kNearerOffset: DepthOffset = { polygonOffset: true, polygonOffsetFactor: 0, polygonOffsetUnits: -1024 };
