import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { Probe_Quantity } from '../src/gen/kerf/v1/analysis_pb';
import { widened } from '../src/ui/plots/plot_canvas';
import { PlotSeries, niceTicks } from '../src/ui/plots/plot_series';
import { kQuantities, probeOf, valueText } from '../src/ui/plots/quantities';

describe('PlotSeries', () => {
  it('keeps the newest samples, and one of a tick', () => {
    const series = new PlotSeries(20);
    for (let tick = 0; tick < 50; ++tick) {
      series.add(tick, ['x'], [tick]);
      series.add(tick, ['x'], [-1]);
    }
    expect(series.ticks.length).toBeLessThanOrEqual(20);
    expect(series.ticks.length).toBeGreaterThan(17);
    expect(series.ticks.at(-1)).toBe(49);
    expect(series.range).toEqual([series.ticks[0], 49]);
    expect(series.nearest(45.4)).toBe(series.ticks.indexOf(45));
  });

  it('begins again after a reset, and for other values', () => {
    const series = new PlotSeries(20);
    series.add(5, ['x'], [1]);
    series.add(6, ['x'], [2]);
    series.add(2, ['x'], [3]);
    expect(series.samples).toEqual([[3]]);
    series.add(3, ['x', 'y'], [4, 5]);
    expect([series.ticks, series.samples]).toEqual([[3], [[4, 5]]]);
  });

  it('has no range without a finite value', () => {
    const series = new PlotSeries(20);
    expect([series.range, series.nearest(0)]).toEqual([undefined, -1]);
    series.add(1, ['x'], [NaN]);
    expect(series.range).toBeUndefined();
    series.add(2, ['x'], [-3]);
    expect(series.range).toEqual([-3, -3]);
  });

  it('is saved with ticks, times and units; a missing value is empty', () => {
    const series = new PlotSeries(20);
    series.add(60, ['xx', 'yy'], [0.01, NaN]);
    series.add(61, ['xx', 'yy'], [0.02, -0.5]);
    expect(series.csv('strain', 1 / 60, 100, '%')).toBe(
      'tick,time_s,strain.xx_%,strain.yy_%\n60,1,1,\n61,1.01666666667,2,-50\n',
    );
  });
});

describe('niceTicks', () => {
  it.each([
    [0, 10, 4, [0, 2, 4, 6, 8, 10]],
    [0, 1, 3, [0, 0.5, 1]],
    [-0.013, 0.021, 3, [-0.01, 0, 0.01, 0.02]],
    [3, 3, 3, [3]],
    [1.2e6, 1.9e6, 3, [1.2e6, 1.4e6, 1.6e6, 1.8e6]],
  ])('are round between %f and %f', (low, high, count, ticks) => {
    expect(niceTicks(low, high, count)).toEqual(ticks);
  });
});

describe('widened', () => {
  it('has a range also for values that are all the same', () => {
    for (const [low, high] of [[0, 0], [5, 5], [-2, -2], [1, 1 + 1e-9], [-1, 3]]) {
      const [from, to] = widened(low, high);
      expect(from < low && to > high).toBe(true);
    }
  });
});

describe('quantities', () => {
  it('are measured as the server wants them', () => {
    const of = (id: string) => kQuantities.find((quantity) => quantity.id === id)!;
    expect(probeOf(of('energy'), 'energy_1', undefined)).toMatchObject({ quantity: Probe_Quantity.ENERGY, points: [] });
    const region = { region: { case: 'all', value: true } };
    expect(probeOf(of('reaction'), 'reaction_2', undefined)).toMatchObject({ name: 'reaction_2', region });
    expect(probeOf(of('strain'), 'strain_3', { x: 0.1, y: 0.2 })).toMatchObject({ points: [{ x: 0.1, y: 0.2 }] });
    for (const { id } of kQuantities) expect(`${id}_1`).toMatch(/^[a-z][a-z0-9_]{0,62}$/);
  });

  it.each([
    [0.00123, 'J', '1.23 mJ'],
    [-1500, 'Pa', '−1.5 kPa'],
    [1.234, '%', '1.23 %'],
    [0.5, 'kg m/s', '0.5 kg m/s'],
    [NaN, 'm', '–'],
  ])('%f %s is read as %s', (value, unit, text) => {
    expect(valueText(value, unit)).toBe(text);
  });
});

describe('colours of plots', () => {
  const css = (name: string) => readFileSync(new URL(`../src/style/${name}.css`, import.meta.url), 'utf8');
  const luminance = (hex: string) => {
    const channels = [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
    const [r, g, b] = channels.map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (a: string, b: string) => {
    const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
    return (high + 0.05) / (low + 0.05);
  };

  it('stand out from cards in both themes', () => {
    const pairs = [...css('plots').matchAll(/--plot-\d: light-dark\((#\w{6}), (#\w{6})\)/g)];
    expect(pairs).toHaveLength(5);
    for (const [, light, dark] of pairs) {
      expect(contrast(light, '#f4f6f9')).toBeGreaterThan(4.5);
      expect(contrast(dark, '#1a2028')).toBeGreaterThan(4.5);
    }
  });
});
