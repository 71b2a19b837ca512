import { Color } from 'three';

// Six colours of viridis (S. van der Walt, N. Smith, 2015, CC0): lightness grows evenly, and the colour-blind read it, too.
const kStops = [0x440154, 0x414487, 0x2a788e, 0x22a884, 0x7ad151, 0xfde725].map((hex) => new Color(hex));
const kSmallestMax = 1e-4;
// The scale ends where 99 % of the vertices are below: at a pin or the end of a cut a few have many times as much.
const kShareBelow = 0.99;
const kMaxSamples = 2000;

/** For legends: CSS, evenly from nothing to the end of the scale. */
export const kStrainStops: readonly string[] = kStops.map((color) => color.getStyle());
export const kStrainGradient = `linear-gradient(to right, ${kStrainStops.join(', ')})`;

/** The next of 1, 2, 5, 10, 20, ... times a power of ten that is not below `value`. */
function roundedUp(value: number): number {
  const decade = 10 ** Math.floor(Math.log10(value));
  for (const step of [1, 2, 5]) if (value <= step * decade * (1 + 1e-9)) return step * decade;
  return 10 * decade;
}

function largestOfMost(strains: Float32Array): number {
  const every = Math.ceil(strains.length / kMaxSamples);
  const samples = Float32Array.from({ length: Math.floor(strains.length / every) }, (_, i) => strains[every * i]).sort();
  return samples[Math.floor(kShareBelow * (samples.length - 1))] ?? 0;
}

/**
 * The end of the scale, -, >= 1e-4: a round number that the strains of nearly all vertices are just below, and that does
 * not change with every frame.
 *
 * @param current  the end so far
 */
export function strainScaleEnd(strains: Float32Array, current: number): number {
  const largest = Math.max(kSmallestMax, largestOfMost(strains));
  return largest > current || largest < 0.2 * current ? roundedUp(largest) : current;
}

/**
 * A colour for each vertex, linear, 3 numbers each: viridis from 0 to `end` and beyond; what is not stretched at all is dark.
 *
 * @param room  is written to and returned where it has exactly the length
 */
export function strainColors(strains: Float32Array, end: number, room?: Float32Array): Float32Array {
  const out = room?.length === 3 * strains.length ? room : new Float32Array(3 * strains.length);
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
