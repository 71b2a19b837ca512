import { Color } from 'three';

// The cool-warm map of K. Moreland, "Diverging color maps for scientific visualization" (2009): blue where the sheet is
// compressed, grey where it is as long as at rest, red where it is stretched. The colour-blind can distinguish its two
// sides.
const kStops = [
  0x3b4cc0, 0x6282ea, 0x8db0fe, 0xb8d0f9, 0xdddddd, 0xf5c4ad, 0xf49a7b, 0xde604d, 0xb40426,
].map((hex) => new Color(hex));
// Size of the table of colours: odd, so that one is in the middle; neighbours differ by at most 1/255 in each channel.
const kNumShades = 1025;
const kSmallestMax = 1e-4;
// Share of the vertices whose strains lie within the scale. A few, at pins and ends of cuts, are many times larger.
const kShareBelow = 0.99;
const kMaxSamples = 2000;

/** CSS colours for legends, at equal distances from the most compressed to the most stretched. */
export const kStrainStops: readonly string[] = kStops.map((color) => color.getStyle());
export const kStrainGradient = `linear-gradient(to right, ${kStrainStops.join(', ')})`;

// Linear colours, 3 numbers each, evenly spaced over the scale. Between stops they are mixed in sRGB, as CSS gradients
// do.
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

/** Returns the smallest number >= `value` that is 1, 2 or 5 times a power of ten. */
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
 * Returns the strain (-) at which the symmetric scale ends, >= 1e-4: a round number that 99 % of the magnitudes do not
 * exceed. It stays while these reach a fifth of it, so that it does not change with every frame.
 *
 * @param current  the present end; 0: none yet
 */
export function strainScaleEnd(strains: Float32Array, current: number): number {
  const largest = Math.max(kSmallestMax, largestOfMost(strains));
  return largest > current || largest < 0.2 * current ? roundedUp(largest) : current;
}

/**
 * Returns a colour for each vertex, linear, 3 numbers each: from blue at `-end` and below over grey at 0 to red at
 * `end` and above.
 *
 * @param room  array for the result, used if it has exactly the right length
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
  /** Place on the scale, from 0 at its left end to 1 at its right end. */
  at: number;
  text: string;
}

/** Returns marks at both ends, at 0 and half way between, as percentages; only the last has the sign "%". */
export function strainTicks(end: number): StrainTick[] {
  return [-1, -0.5, 0, 0.5, 1].map((share) => {
    const percent = String(Number((100 * Math.abs(share) * end).toPrecision(2)));
    return { at: 0.5 + 0.5 * share, text: `${share < 0 ? '−' : ''}${percent}${share === 1 ? ' %' : ''}` };
  });
}
