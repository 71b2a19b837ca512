import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { FrameStatsSchema } from '../src/gen/kerf/v1/stream_pb';
import { SampleWindow } from '../src/stream/sample_window';
import type { SheetArrays } from '../src/stream/sheet_copy';
import { StreamMeter } from '../src/stream/stream_meter';
import { bytesText, kStatistics, statisticsTexts } from '../src/ui/statistics_text';

describe('SampleWindow', () => {
  it('forgets what is older than its span, and the oldest where there is no room', () => {
    const window = new SampleWindow(1000, 4);
    for (let i = 0; i < 7; ++i) window.add(10 * i, i);
    const seen: number[] = [];
    window.forEach((_, value) => seen.push(value));
    expect(seen).toEqual([3, 4, 5, 6]);
    window.forget(1049);
    expect([window.count, window.sum(), window.max(), window.last()]).toEqual([2, 11, 6, 6]);
    window.forget(1060);
    expect([window.count, window.last(), window.quantile(0.5)]).toEqual([0, undefined, undefined]);
  });

  it('has quantiles by nearest rank, of numbers in any order', () => {
    const window = new SampleWindow(1e6, 100);
    for (let i = 0; i < 100; ++i) window.add(i, (i * 37) % 100);
    expect([0, 0.5, 0.95, 1].map((q) => window.quantile(q))).toEqual([0, 49, 94, 99]);
  });

  it('has a rate over the time that it looks back, and over a quarter of the span at the start', () => {
    const window = new SampleWindow(1000, 100);
    expect(window.rate(0)).toBe(0);
    window.add(0, 50);
    expect(window.rate(0)).toBe(4);
    for (let ms = 20; ms < 500; ms += 20) window.add(ms, 50);
    expect(window.rate(500)).toBe(50);
    expect(window.rate(500, window.sum())).toBe(2500);
  });
});

describe('bytesText', () => {
  it('has three digits and the unit', () => {
    expect([0, 999, 1000, 12_345, 999_499, 999_500, 5e9, 7e12].map(bytesText)).toEqual([
      '0 B',
      '999 B',
      '1 kB',
      '12.3 kB',
      '999 kB',
      '1 MB',
      '5 GB',
      '7000 GB',
    ]);
  });
});

describe('statisticsTexts', () => {
  it('says what the stream did in the last seconds', () => {
    const meter = new StreamMeter();
    // 30 frames a second, each fifth a keyframe of ten times the bytes, each of the others a delta.
    for (let i = 0; i < 150; ++i) {
      const nowMs = (i * 1000) / 30;
      const isKeyframe = i % 5 === 0;
      const delivery = { numBytes: isKeyframe ? 10_000 : 1000, isKeyframe, numUnacknowledged: 1 + (i % 3), decodeMs: 2 };
      meter.arrived(nowMs, delivery, { skipped: 1, tickCpuUs: i < 140 ? 1500 : 4000 });
      meter.wasDrawn(nowMs, i < 140 ? 20 : 90);
    }
    const stats = create(FrameStatsSchema, { strainedShare: 0.0125, intersections: 1063n, realTimeFactor: 0.5, overruns: 1234n, slippedS: 2.5, numTriangles: 4802 });
    const sheet = { numVertices: 2500, numPieces: 3, stats } as SheetArrays;
    expect(statisticsTexts(meter, sheet, 'VP8, 640 × 360', 5000)).toEqual({
      format: 'VP8, 640 × 360',
      fps: '30 / s',
      age: '20 / 90 ms',
      frames: '30 / s',
      bytes: '84 kB/s, 2.8 kB',
      keyframes: '20 %',
      skipped: '30 / s',
      window: '3',
      decode: '2.0 / 2.0 ms',
      tick: '1.50 / 4.00 ms',
      realTime: '0.50 ×',
      overruns: '1,234 (2.50 s)',
      vertices: '2,500',
      triangles: '4,802',
      pieces: '3',
      intersections: '1,063',
      strained: '1.3 %',
    });
  });

  it('says in words that the sheet does not move', () => {
    const texts = (still: object) => {
      const stats = create(FrameStatsSchema, still);
      const sheet = { numVertices: 4, numPieces: 1, stats } as SheetArrays;
      const { fps, age, realTime } = statisticsTexts(new StreamMeter(), sheet, 'the mesh', 0);
      return [fps, age, realTime];
    };
    expect(texts({ paused: true })).toEqual(['paused', 'current', 'paused']);
    expect(texts({ sleeping: true })).toEqual(['at rest', 'current', 'at rest']);
  });

  it('says nothing where nothing came, and has a text for every line', () => {
    const meter = new StreamMeter();
    const texts = statisticsTexts(meter, { numVertices: 0, numPieces: 0, stats: undefined } as SheetArrays, 'the mesh', 0);
    expect(Object.keys(texts).sort()).toEqual(Object.keys(kStatistics).sort());
    expect(texts).toMatchObject({ age: '–', keyframes: '–', window: '–', tick: '–', bytes: '0 B/s' });
  });
});
