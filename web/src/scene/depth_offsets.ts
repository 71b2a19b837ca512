/** A shift in depth, away from the viewer, with which a material is drawn. */
export interface DepthOffset {
  polygonOffset: true;
  polygonOffsetFactor: number;
  polygonOffsetUnits: number;
}

/** The cloth lies behind the lips and wires drawn on it, and in front of what it rests on. */
export const kClothOffset: DepthOffset = { polygonOffset: true, polygonOffsetFactor: 1.5, polygonOffsetUnits: 2 };

/**
 * Solids and floors lie behind the cloth that rests on them, also where a pixel covers much of a surface. The factor is well
 * above the cloth's own, whose wrinkles are steeper than the solid. The units are 0.15 % of the first view's distance in a
 * depth buffer of 24 bits, as in the server's pictures.
 */
export const kSupportOffset: DepthOffset = { polygonOffset: true, polygonOffsetFactor: 4, polygonOffsetUnits: 256 };

/**
 * Drawings on the cloth are nearer than it, by 0.6 % of the first view's distance. Lines have a width, on slopes too, and
 * are to be hidden by folds, not by the cloth that they lie on.
 */
export const kNearerOffset: DepthOffset = { polygonOffset: true, polygonOffsetFactor: 0, polygonOffsetUnits: -1024 };
