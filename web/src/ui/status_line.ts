import type { FrameStats } from '../gen/kerf/v1/stream_pb';
import type { SheetFigures } from '../stream/sheet_copy';
import { SampleWindow } from '../stream/sample_window';
import { element, setText } from './dom';
import { isBehind, kCurrent, stillText } from './run_text';

// Window over which pictures are counted, and room for those of the fastest screens.
const kFpsWindowMs = 1000;
const kMostPictures = 480;
const kNothing = '–';

/**
 * Shows tick, real-time factor, vertices, pieces, frame age and drawn frames per second. Shows pairs of triangles that
 * pass through each other, and how long changes have waited to be stored, while there are any.
 */
export class StatusLine {
  private readonly tick = element('status-tick');
  private readonly realTime = element('status-rtf');
  private readonly vertices = element('status-vertices');
  private readonly pieces = element('status-pieces');
  private readonly intersecting = element('status-intersecting');
  private readonly intersections = element('status-intersections');
  private readonly unconfirmed = element('status-unconfirmed');
  private readonly unconfirmedTime = element('status-unconfirmed-time');
  private readonly age = element('status-age');
  private readonly fps = element('status-fps');
  private readonly pictures = new SampleWindow(kFpsWindowMs, kMostPictures);

  /** Call it when a picture was drawn, at `nowMs` (performance.now()). */
  drawn(nowMs: number): void {
    this.pictures.add(nowMs, 1);
  }

  /**
   * @param sheet  undefined if no sheet is shown
   * @param ageMs  age of the shown state; undefined if it has none
   */
  update(sheet: SheetFigures | undefined, ageMs: number | undefined, nowMs: number): void {
    this.pictures.forget(nowMs);
    const stats = sheet?.stats;
    const still = stillText(stats);
    // Shows the rate also for a still sheet, because its view may move.
    setText(this.fps, this.pictures.count === 0 && still ? still : String(this.pictures.count));
    setText(this.tick, sheet?.tick.toLocaleString('en') ?? kNothing);
    setText(this.vertices, sheet?.numVertices.toLocaleString('en') ?? kNothing);
    setText(this.pieces, sheet ? String(sheet.numPieces) : kNothing);
    setText(this.realTime, still ?? realTimeText(stats));
    this.realTime.dataset.level = isBehind(stats) ? 'warn' : '';
    this.intersecting.hidden = !stats?.intersections;
    setText(this.intersections, stats?.intersections.toLocaleString('en') ?? kNothing);
    this.unconfirmed.hidden = !stats?.unconfirmedMs;
    setText(this.unconfirmedTime, ageText(stats?.unconfirmedMs));
    setText(this.age, still ? kCurrent : ageText(sheet && ageMs));
  }
}

function realTimeText(stats: FrameStats | undefined): string {
  return stats ? `${stats.realTimeFactor.toFixed(2)} ×` : kNothing;
}

function ageText(ageMs: number | undefined): string {
  if (ageMs === undefined) return kNothing;
  return ageMs < 1000 ? `${ageMs.toFixed(0)} ms` : `${(ageMs / 1000).toFixed(1)} s`;
}
