import type { FrameStats } from '../gen/kerf/v1/stream_pb';
import type { SheetFigures } from '../stream/sheet_copy';
import { SampleWindow } from '../stream/sample_window';
import { element, setText } from './dom';
import { speedOf } from './speeds';

// A second of pictures, on the fastest of screens.
const kFpsWindowMs = 1000;
const kMostPictures = 480;
const kNothing = '–';

/** Tick, real-time factor, vertices, pieces, frame age and drawn frames a second. */
export class StatusLine {
  private readonly tick = element('status-tick');
  private readonly realTime = element('status-rtf');
  private readonly vertices = element('status-vertices');
  private readonly pieces = element('status-pieces');
  private readonly age = element('status-age');
  private readonly fps = element('status-fps');
  private readonly pictures = new SampleWindow(kFpsWindowMs, kMostPictures);

  /** A frame was drawn at `nowMs` (performance.now()). */
  drawn(nowMs: number): void {
    this.pictures.add(nowMs, 1);
  }

  /**
   * @param sheet  undefined where none is shown
   * @param ageMs  of the shown state; undefined where it has none
   */
  update(sheet: SheetFigures | undefined, ageMs: number | undefined, nowMs: number): void {
    this.pictures.forget(nowMs);
    setText(this.fps, String(this.pictures.count));
    const stats = sheet?.stats;
    setText(this.tick, sheet?.tick.toLocaleString('en') ?? kNothing);
    setText(this.vertices, sheet?.numVertices.toLocaleString('en') ?? kNothing);
    setText(this.pieces, sheet ? String(sheet.numPieces) : kNothing);
    setText(this.realTime, realTimeText(stats));
    this.realTime.dataset.level = isBehind(stats) ? 'warn' : '';
    setText(this.age, ageText(sheet && ageMs));
  }
}

function realTimeText(stats: FrameStats | undefined): string {
  if (!stats) return kNothing;
  if (stats.paused) return 'paused';
  if (stats.sleeping) return 'at rest';
  return `${stats.realTimeFactor.toFixed(2)} ×`;
}

function ageText(ageMs: number | undefined): string {
  if (ageMs === undefined) return kNothing;
  return ageMs < 1000 ? `${ageMs.toFixed(0)} ms` : `${(ageMs / 1000).toFixed(1)} s`;
}

// In slow motion a sheet that keeps its pace is not behind.
function isBehind(stats: FrameStats | undefined): boolean {
  return stats !== undefined && !stats.paused && !stats.sleeping && stats.realTimeFactor < 0.95 * speedOf(stats);
}
