import type { FrameStats } from '../gen/kerf/v1/stream_pb';
import type { SheetFigures } from '../stream/sheet_copy';
import type { StreamMeter } from '../stream/stream_meter';
import { kCurrent, stillText } from './run_text';

/** Labels and explanations of the overlay's figures, in the order in which they are shown. */
export const kStatistics = {
  format: ['stream', 'The mesh, or pictures that the server draws; frames of the mesh beside pictures are not counted here'],
  fps: ['drawn', 'Pictures drawn per second'],
  age: ['frame age', 'Time from the end of the shown tick until it was drawn: median and 95th percentile'],
  frames: ['frames', 'Frames of the mesh, or pictures, received per second'],
  bytes: ['bytes', 'Bytes per second, and per frame'],
  keyframes: ['keyframes', 'Share of the frames that can be decoded by themselves; the others are differences from the previous frame'],
  skipped: ['skipped', 'Ticks per second that were not sent, because this viewer was not ready for them'],
  window: ['in flight', 'Most frames that had arrived and were not yet acknowledged; the server sends none beyond its window'],
  decode: ['decoding', 'Time to decode a frame, in the worker: median and 95th percentile'],
  tick: ['tick time', 'Time that a tick takes on the server: median and 95th percentile'],
  realTime: ['real time', 'Simulated over wall time'],
  overruns: ['overruns', 'Ticks that ended after their deadline, and simulated time given up'],
  vertices: ['vertices', ''],
  triangles: ['triangles', ''],
  pieces: ['pieces', ''],
  intersections: ['intersecting', 'Pairs of triangles that pass through each other: counted for sheets whose folds touch'],
  strained: ['overstrained', 'Share of the sheet’s area that is strained beyond its material’s limit: see Physics'],
} as const;

export type StatisticId = keyof typeof kStatistics;

const kNothing = '–';

/** Formats a number of bytes such as 1.23 kB: SI prefixes, three digits. */
export function bytesText(bytes: number): string {
  const units = ['B', 'kB', 'MB', 'GB'];
  let unit = 0;
  while (bytes >= 999.5 && unit < units.length - 1) {
    bytes /= 1000;
    unit += 1;
  }
  return `${unit === 0 ? bytes.toFixed(0) : Number(bytes.toPrecision(3))} ${units[unit]}`;
}

function pair(low: number | undefined, high: number | undefined, unit: string, digits: number): string {
  if (low === undefined || high === undefined) return kNothing;
  return `${low.toFixed(digits)} / ${high.toFixed(digits)} ${unit}`;
}

function sheetTexts(sheet: SheetFigures, stats: FrameStats | undefined) {
  return {
    realTime: stillText(stats) ?? (stats ? `${stats.realTimeFactor.toFixed(2)} ×` : kNothing),
    overruns: stats ? `${stats.overruns.toLocaleString('en')} (${stats.slippedS.toFixed(2)} s)` : kNothing,
    vertices: sheet.numVertices.toLocaleString('en'),
    triangles: stats ? stats.numTriangles.toLocaleString('en') : kNothing,
    pieces: sheet.numPieces.toLocaleString('en'),
    intersections: stats ? stats.intersections.toLocaleString('en') : kNothing,
    strained: stats ? `${Number((100 * stats.strainedShare).toPrecision(2))} %` : kNothing,
  };
}

/** Returns the texts of the overlay at `nowMs`; call meter.forget(nowMs) before. */
export function statisticsTexts(
  meter: StreamMeter,
  sheet: SheetFigures | undefined,
  format: string,
  nowMs: number,
): Partial<Record<StatisticId, string>> {
  const { ages, bytes, keyframes, decodeTimes, tickTimes, unacknowledged } = meter;
  const hasFrames = bytes.count > 0;
  const still = stillText(sheet?.stats);
  return {
    format,
    fps: still && meter.drawn.count === 0 ? still : `${meter.drawn.rate(nowMs).toFixed(0)} / s`,
    age: still && ages.count === 0 ? kCurrent : pair(ages.quantile(0.5), ages.quantile(0.95), 'ms', 0),
    frames: `${bytes.rate(nowMs).toFixed(0)} / s`,
    bytes: hasFrames
      ? `${bytesText(bytes.rate(nowMs, bytes.sum()))}/s, ${bytesText(bytes.sum() / bytes.count)}`
      : '0 B/s',
    keyframes: hasFrames ? `${((100 * keyframes.sum()) / keyframes.count).toFixed(0)} %` : kNothing,
    skipped: `${meter.skipped.rate(nowMs, meter.skipped.sum()).toFixed(0)} / s`,
    window: hasFrames ? unacknowledged.max().toFixed(0) : kNothing,
    decode: pair(decodeTimes.quantile(0.5), decodeTimes.quantile(0.95), 'ms', 1),
    tick: pair(scaled(tickTimes.quantile(0.5)), scaled(tickTimes.quantile(0.95)), 'ms', 2),
    ...(sheet && sheetTexts(sheet, sheet.stats)),
  };
}

function scaled(us: number | undefined): number | undefined {
  return us === undefined ? undefined : us / 1000;
}
