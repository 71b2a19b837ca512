import { Color } from 'three';

// Six colours of viridis (S. van der Walt, N. Smith, 2015, CC0): lightness grows evenly, and the colour-blind read it, too.
const kStops = [0x440154, 0x414487, 0x2a788e, 0x22a884, 0x7ad151, 0xfde725].map((hex) => new Color(hex));
const kSmallestMax = 1e-4;

/** For the legend: left to right, CSS. */
export const kStrainGradient = `linear-gradient(to right, ${kStops.map((color) => color.getStyle()).join(', ')})`;

/** The next of 1, 2, 5, 10, 20, ... times a power of ten that is not below `value`. */
function roundedUp(value: number): number {
  const decade = 10 ** Math.floor(Math.log10(value));
  for (const step of [1, 2, 5]) if (value <= step * decade * (1 + 1e-9)) return step * decade;
  return 10 * decade;
}

/**
 * The end of the scale, -, >= 1e-4: a round number that the largest strain is just below, and that does not change with
 * every frame.
 *
 * @param current  the end so far
 */
export function strainScaleEnd(strains: Float32Array, current: number): number {
  let largest = kSmallestMax;
  for (const strain of strains) if (strain > largest) largest = strain;
  return largest > current || largest < 0.2 * current ? roundedUp(largest) : current;
}

/**
 * A colour for each vertex, linear, 3 numbers each: viridis from 0 to `end`; what is not stretched at all is dark.
 */
export function strainColors(strains: Float32Array, end: number): Float32Array {
  const out = new Float32Array(3 * strains.length);
  const last = kStops.length - 1;
  for (let v = 0; v < strains.length; ++v) {
    const at = last * Math.min(1, Math.max(0, strains[v] / end));
    const from = Math.min(Math.floor(at), last - 1);
    const share = at - from;
    const [low, high] = [kStops[from], kStops[from + 1]];
    out[3 * v] = low.r + share * (high.r - low.r);
    out[3 * v + 1] = low.g + share * (high.g - low.g);
    out[3 * v + 2] = low.b + share * (high.b - low.b);
  }
  return out;
}
