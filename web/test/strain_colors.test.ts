import { Color } from 'three';
import { describe, expect, it } from 'vitest';
import { strainColors, strainScaleEnd } from '../src/scene/strain_colors';

describe('strainScaleEnd', () => {
  it('is a round number that stays while the strains stay about as large', () => {
    const end = strainScaleEnd(Float32Array.of(0.013, 0.013), 0);
    expect(end).toBeCloseTo(0.02);
    expect(strainScaleEnd(Float32Array.of(0.019), end)).toBe(end);
    expect(strainScaleEnd(Float32Array.of(0.005), end)).toBe(end);
    expect(strainScaleEnd(Float32Array.of(0.021), end)).toBeCloseTo(0.05);
    expect(strainScaleEnd(Float32Array.of(0.002), end)).toBeCloseTo(0.002);
  });

  it('leaves out the few vertices at pins and ends of cuts', () => {
    const strains = new Float32Array(5000).fill(0.004);
    strains.fill(0.9, 0, 20);
    expect(strainScaleEnd(strains, 0)).toBeCloseTo(0.005);
  });

  it('does not follow noise about 0', () => {
    expect(strainScaleEnd(Float32Array.of(-0.5, 1e-9), 0)).toBeCloseTo(1e-4);
    expect(strainScaleEnd(new Float32Array(0), 0)).toBeCloseTo(1e-4);
  });
});

describe('strainColors', () => {
  const lightness = (colors: Float32Array, v: number) =>
    0.2126 * colors[3 * v] + 0.7152 * colors[3 * v + 1] + 0.0722 * colors[3 * v + 2];

  it('grows lighter from dark violet at 0 to yellow at the end, and stays within', () => {
    const strains = Float32Array.from({ length: 60 }, (_, i) => -0.02 + 0.002 * i);
    const colors = strainColors(strains, 0.08);
    const dark = new Color(0x440154);
    expect([...colors.subarray(0, 3)].map((x) => x.toFixed(4))).toEqual(dark.toArray().map((x) => x.toFixed(4)));
    for (let v = 1; v < 60; ++v) expect(lightness(colors, v)).toBeGreaterThanOrEqual(lightness(colors, v - 1));
    expect([...colors.subarray(177)].map((x) => x.toFixed(4))).toEqual(
      new Color(0xfde725).toArray().map((x) => x.toFixed(4)),
    );
  });
});
