import { Color } from 'three';

// The cool-warm map of K. Moreland, "Diverging color maps for scientific visualization" (2009): blue where the sheet is
// compressed, grey where it is as long as at rest, red where it is stretched. The colour-blind tell its sides apart.
const kStops = [
  0x3b4cc0, 0x6282ea, 0x8db0fe, 0xb8d0f9, 0xdddddd, 0xf5c4ad, 0xf49a7b, 0xde604d, 0xb40426,
].map((hex) => new Color(hex));
// The table of colours has one in its middle, and neighbours differ by at most one in a channel of a picture.
const kNumShades = 1025;
const kSmallestMax = 1e-4;
// The scale ends where 99 % of the vertices are below: at a pin or the end of a cut a few have many times as much.
const kShareBelow = 0.99;
const kMaxSamples = 2000;

/** For legends: CSS, evenly from the most compressed to the most stretched. */
export const kStrainStops: readonly string[] = kStops.map((color) => color.getStyle());
export const kStrainGradient = `linear-gradient(to right, ${kStrainStops.join(', ')})`;

// Linear, 3 numbers each, evenly over the scale; between stops they are mixed in sRGB, as in a gradient of CSS.
const kShades = makeShades();

function makeShades(): Float32Array {
  const shades = new Float32Array(3 * kNumShades);
  const last = kStops.length - 1;
  const [low, high] = [new Color(), new Color()];
  for (let i = 0; i < kNumShades; ++i) {
    const place = (last * i) / (kNumShades - 1);
    const from = Math.min(Math.floor(place), last - 1);
    low.copy(kStops[from]).convertLinearToSRGB();
    high.copy(kStops[from + 1]).convertLinearToSRGB();
    low.lerp(high, place - from).convertSRGBToLinear().toArray(shades, 3 * i);
  }
  return shades;
}

/** The next of 1, 2, 5, 10, 20, ... times a power of ten that is not below `value`. */
function roundedUp(value: number): number {
  const decade = 10 ** Math.floor(Math.log10(value));
  for (const step of [1, 2, 5]) if (value <= step * decade * (1 + 1e-9)) return step * decade;
  return 10 * decade;
}

function largestOfMost(strains: Float32Array): number {
  const every = Math.ceil(strains.length / kMaxSamples);
  const samples = Float32Array.from({ length: Math.floor(strains.length / every) }, (_, i) => Math.abs(strains[every * i]));
  samples.sort();
  return samples[Math.floor(kShareBelow * (samples.length - 1))] ?? 0;
}

/**
 * The end of the scale, -, >= 1e-4: a round number that the magnitudes of nearly all strains are just below, and that does
 * not change with every frame. The scale begins at its negative.
 *
 * @param current  the end so far
 */
export function strainScaleEnd(strains: Float32Array, current: number): number {
  const largest = Math.max(kSmallestMax, largestOfMost(strains));
  return largest > current || largest < 0.2 * current ? roundedUp(largest) : current;
}

/**
 * A colour for each vertex, linear, 3 numbers each: from blue at `-end` and below over grey at 0 to red at `end` and above.
 *
 * @param room  is written to and returned where it has exactly the length
 */
export function strainColors(strains: Float32Array, end: number, room?: Float32Array): Float32Array {
  const out = room?.length === 3 * strains.length ? room : new Float32Array(3 * strains.length);
  for (let v = 0; v < strains.length; ++v) {
    const share = Math.min(1, Math.max(-1, strains[v] / end));
    const shade = 3 * Math.round(0.5 * (1 + share) * (kNumShades - 1));
    for (let k = 0; k < 3; ++k) out[3 * v + k] = kShades[shade + k];
  }
  return out;
}

/** A mark of the scale. */
export interface StrainTick {
  /** From 0 at the scale's left end to 1 at its right one. */
  at: number;
  text: string;
}

/** Marks at both ends, at nothing and half way: percentages, of which the last says so. */
export function strainTicks(end: number): StrainTick[] {
  return [-1, -0.5, 0, 0.5, 1].map((share) => {
    const percent = String(Number((100 * Math.abs(share) * end).toPrecision(2)));
    return { at: 0.5 + 0.5 * share, text: `${share < 0 ? '−' : ''}${percent}${share === 1 ? ' %' : ''}` };
  });
}
