import { distance, simplify } from '../../geometry/curve';
import type { Point2 } from '../../geometry/locator';
import { PointDrawing } from './drawing';
import type { DrawnCut, PreviewLine } from './drawing';

// Limit of kerf.v1.Polyline.
const kMaxPoints = 4096;
// A stroke is closed if it ends within this many tremors of its start and went more than three times as far away.
const kClosingTremors = 8;

/** One stroke of the hand, smoothed by its tremor. */
export class FreehandDrawing extends PointDrawing {
  private isDrawing = false;

  override get handles(): readonly Point2[] {
    return [];
  }

  get isReady(): boolean {
    return !this.isDrawing && this.points.length >= 2;
  }

  get prompt(): string {
    if (!this.isReady) return 'Draw a line; end it where it began to cut a piece out';
    return this.isClosed ? 'Cut the loop, or draw another' : 'Cut the line, or draw another';
  }

  override press(point: Point2): boolean {
    this.points = [point];
    this.isDrawing = true;
    return true;
  }

  override drag(point: Point2): void {
    this.points.push(point);
    // Halves the points of a very long stroke, which also leaves room for the point that closes it.
    if (this.points.length >= kMaxPoints) this.points = this.points.filter((_, i) => i % 2 === 0);
  }

  override release(tremor: number): void {
    this.isDrawing = false;
    const [first] = this.points;
    const reach = kClosingTremors * tremor;
    const isLoop = distance(first, this.points[this.points.length - 1]) < reach;
    if (isLoop && this.points.some((point) => distance(first, point) > 3 * reach)) {
      // Removes points near the start: if the end crossed the start, the cut would separate a sliver.
      while (distance(first, this.points[this.points.length - 1]) < reach) this.points.pop();
      this.points.push(first);
    }
    const line = simplify(this.points, tremor);
    this.points = line.length < 2 || line.every((point) => distance(first, point) < tremor) ? [] : line;
  }

  lines(): PreviewLine[] {
    return [{ points: this.points }];
  }

  cut(): DrawnCut {
    return { curve: { kind: { case: 'polyline', value: { points: this.points } } } };
  }

  private get isClosed(): boolean {
    return this.points[0] === this.points[this.points.length - 1];
  }
}
