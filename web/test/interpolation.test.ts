import { describe, expect, it } from 'vitest';
import { Interpolation } from '../src/stream/interpolation';

const at = (...values: number[]) => Float32Array.from(values);

describe('Interpolation', () => {
  it('shows frames that come as often as pictures are drawn at once', () => {
    const way = new Interpolation();
    const shown = at(0);
    for (let frame = 1; frame <= 30; ++frame) {
      way.take(shown, at(frame), (frame * 1000) / 60, frame > 1);
      expect(shown[0]).toBe(frame);
      expect(way.advance(shown, (frame * 1000) / 60 + 5)).toBe(false);
    }
  });

  it('moves evenly between frames that come ten times a second, and is hardly more than one behind', () => {
    const way = new Interpolation();
    const shown = at(0);
    way.take(shown, at(0), 0, false);
    const seen: number[] = [];
    for (let ms = 1; ms <= 3000; ++ms) {
      if (ms % 100 === 0) way.take(shown, at(ms / 100), ms, true);
      if (ms % 16 !== 0) continue;
      way.advance(shown, ms);
      if (ms < 1000) continue;
      seen.push(shown[0]);
      expect(shown[0]).toBeGreaterThanOrEqual(Math.floor(ms / 100) - 1.2);
      expect(shown[0]).toBeLessThanOrEqual(ms / 100);
    }
    const steps = seen.slice(1).map((value, i) => value - seen[i]);
    expect(Math.min(...steps)).toBeGreaterThan(0.1);
    expect(Math.max(...steps)).toBeLessThan(0.22);
  });

  it('arrives, and then rests', () => {
    const way = new Interpolation();
    const shown = at(0, 0);
    way.take(shown, at(0, 0), 0, false);
    way.take(shown, at(8, -8), 100, true);
    expect(way.advance(shown, 150)).toBe(true);
    expect([...shown]).toEqual([4, -4]);
    expect(way.advance(shown, 400)).toBe(true);
    expect([...shown]).toEqual([8, -8]);
    expect(way.advance(shown, 416)).toBe(false);
  });

  it('jumps where positions do not go on, and after a pause', () => {
    const way = new Interpolation();
    const shown = at(0);
    way.take(shown, at(1), 0, false);
    expect(shown[0]).toBe(1);
    way.take(shown, at(5), 100, false);
    expect(shown[0]).toBe(5);
    way.take(shown, at(9), 5000, true);
    expect(shown[0]).toBe(9);
    expect(way.advance(shown, 5001)).toBe(false);
  });
});
