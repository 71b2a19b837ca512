import { beforeEach, describe, expect, it } from 'vitest';
import { DrawingQuality } from '../src/scene/drawing_quality';

const kFull = { scale: 1, hasShadows: true };
const kCoarsest = { scale: 0.5, hasShadows: false };

describe('DrawingQuality', () => {
  let quality: DrawingQuality;
  let nowMs: number;

  /** Draws a moving sheet for so long, each picture taking the time that is given for its quality. */
  const draw = (durationMs: number, pictureMs: (scale: number, hasShadows: boolean) => number) => {
    for (const endMs = nowMs + durationMs; nowMs < endMs; ) {
      const { scale, hasShadows } = quality.at(nowMs, true);
      const tookMs = pictureMs(scale, hasShadows);
      quality.moved(nowMs);
      nowMs += tookMs;
      quality.took(tookMs);
    }
    return quality.at(nowMs, true);
  };

  beforeEach(() => {
    quality = new DrawingQuality();
    nowMs = 0;
  });

  it('stays at full resolution while pictures come often enough', () => {
    expect(draw(30_000, () => 1000 / 21)).toEqual(kFull);
    expect(quality.isTooSlow).toBe(false);
  });

  it('becomes coarser step by step where they do not, and shadows go last', () => {
    const steps = Array.from({ length: 4 }, () => draw(1000, () => 60));
    expect(steps).toEqual([
      { scale: 0.75, hasShadows: true },
      { scale: 0.5, hasShadows: true },
      kCoarsest,
      kCoarsest,
    ]);
    expect(quality.isTooSlow).toBe(true);
  });

  it('stops where it is quick enough', () => {
    // A picture takes as long as it has pixels, and 5 ms.
    expect(draw(20_000, (scale) => 5 + 70 * scale ** 2)).toEqual({ scale: 0.75, hasShadows: true });
    expect(quality.isTooSlow).toBe(false);
  });

  it('is not disturbed by a single hitch, or by few pictures', () => {
    let isHitch = false;
    expect(draw(4000, () => ((isHitch = !isHitch && nowMs > 2000 && nowMs < 2020) ? 900 : 16))).toEqual(kFull);
    quality.took(700);
    quality.took(700);
    expect(quality.at(nowMs, true)).toEqual(kFull);
  });

  it('becomes finer again only after a while at a good rate', () => {
    draw(5000, () => 100);
    expect(draw(2500, () => 16)).toEqual(kCoarsest);
    expect(draw(1500, () => 16)).toEqual({ scale: 0.5, hasShadows: true });
    expect(draw(10_000, () => 16)).toEqual(kFull);
    expect(quality.isTooSlow).toBe(false);
  });

  it('tries a level that was too slow more and more seldom', () => {
    let numChanges = 0;
    let level = '';
    draw(600_000, (scale, hasShadows) => {
      const now = `${scale} ${hasShadows}`;
      numChanges += now === level ? 0 : 1;
      level = now;
      return hasShadows ? 60 : 16;
    });
    // Without a growing patience there would be some 300.
    expect(numChanges).toBeLessThan(40);
    expect(numChanges).toBeGreaterThan(10);
  });

  it('is full for a still picture, half a second after the last change', () => {
    draw(5000, () => 100);
    quality.moved(nowMs);
    expect(quality.at(nowMs + 499, false)).toEqual(kCoarsest);
    expect(quality.at(nowMs + 500, false)).toEqual(kFull);
    // The sheet moves, though no frame came.
    expect(quality.at(nowMs + 500, true)).toEqual(kCoarsest);
    quality.moved(nowMs + 700);
    expect(quality.at(nowMs + 700, false)).toEqual(kCoarsest);
  });
});
