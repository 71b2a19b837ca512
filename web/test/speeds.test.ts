import { describe, expect, it } from 'vitest';
import { kSpeeds, nextSpeed, speedOf, speedText } from '../src/ui/speeds';

describe('speeds', () => {
  it('are such as the server takes, with real time among them', () => {
    expect(kSpeeds).toContain(1);
    expect(Math.min(...kSpeeds)).toBeGreaterThanOrEqual(0.01);
    expect(Math.max(...kSpeeds)).toBe(4);
  });

  it('are told as people say them', () => {
    expect([1 / 16, 0.5, 1, 4, 0.2, 0.123456].map(speedText)).toEqual(['1/16 ×', '1/2 ×', '1 ×', '4 ×', '0.2 ×', '0.123 ×']);
  });

  it('go from any one to the next, and stay at the ends', () => {
    expect([nextSpeed(1, -1), nextSpeed(1, 1), nextSpeed(0.2, -1), nextSpeed(0.2, 1)]).toEqual([0.5, 2, 0.125, 0.25]);
    expect([nextSpeed(4, 1), nextSpeed(1 / 64, -1), nextSpeed(0.01, -1)]).toEqual([4, 1 / 64, 1 / 64]);
  });

  it('of a recording without one is that of real time', () => {
    expect([speedOf({ speed: 0 }), speedOf({ speed: 0.25 })]).toEqual([1, 0.25]);
  });
});
