import { Color } from 'three';
import { describe, expect, it } from 'vitest';
import { kStrainStops, strainColors, strainScaleEnd, strainTicks } from '../src/scene/strain_colors';

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

  it('counts compression as it counts stretch', () => {
    expect(strainScaleEnd(Float32Array.of(-0.013, -0.013, 0.002), 0)).toBeCloseTo(0.02);
  });

  it('does not follow noise about 0', () => {
    expect(strainScaleEnd(Float32Array.of(-2e-5, 1e-9), 0)).toBeCloseTo(1e-4);
    expect(strainScaleEnd(new Float32Array(0), 0)).toBeCloseTo(1e-4);
  });
});

describe('strainTicks', () => {
  it.each([
    [0.1, ['−10', '−5', '0', '5', '10 %']],
    [0.005, ['−0.5', '−0.25', '0', '0.25', '0.5 %']],
    [1e-4, ['−0.01', '−0.005', '0', '0.005', '0.01 %']],
  ])('are round percentages at even places: %d', (end, texts) => {
    const ticks = strainTicks(end);
    expect(ticks.map(({ text }) => text)).toEqual(texts);
    expect(ticks.map(({ at }) => at)).toEqual([0, 0.25, 0.5, 0.75, 1]);
  });
});

describe('strainColors', () => {
  const lightness = (colors: Float32Array, v: number) =>
    0.2126 * colors[3 * v] + 0.7152 * colors[3 * v + 1] + 0.0722 * colors[3 * v + 2];

  const linear = (color: Color) => color.toArray().map((x) => x.toFixed(4));
  const at = (colors: Float32Array, v: number) => [...colors.subarray(3 * v, 3 * v + 3)].map((x) => x.toFixed(4));

  it('go from blue over grey to red, darker the farther from 0, and stay within', () => {
    const strains = Float32Array.from({ length: 51 }, (_, i) => 0.004 * (i - 25));
    const colors = strainColors(strains, 0.08);
    for (const v of [0, 5]) expect(at(colors, v)).toEqual(linear(new Color(0x3b4cc0)));
    expect(at(colors, 25)).toEqual(linear(new Color(0xdddddd)));
    for (const v of [45, 50]) expect(at(colors, v)).toEqual(linear(new Color(0xb40426)));
    for (let v = 26; v < 51; ++v) expect(lightness(colors, v)).toBeLessThanOrEqual(lightness(colors, v - 1));
    for (let v = 0; v < 25; ++v) expect(lightness(colors, v)).toBeLessThanOrEqual(lightness(colors, v + 1));
  });

  it('are those of the legend, between whose stops a browser mixes in sRGB', () => {
    const srgb = (style: string) => style.match(/\d+/g)!.map(Number);
    for (let i = 0; i + 1 < kStrainStops.length; ++i) {
      const share = (2 * (i + 0.25)) / (kStrainStops.length - 1) - 1;
      const sheet = srgb(new Color().fromArray(strainColors(Float32Array.of(share), 1)).getStyle());
      const [low, high] = [srgb(kStrainStops[i]), srgb(kStrainStops[i + 1])];
      sheet.forEach((value, k) => expect(Math.abs(value - 0.75 * low[k] - 0.25 * high[k])).toBeLessThan(1.5));
    }
  });
});
