import type { Point2 } from '../../geometry/locator';
import { pressVerb } from '../press_verb';
import { PointDrawing } from './drawing';
import type { DrawnCut, PreviewLine } from './drawing';

// Limit of kerf.v1.Polyline.
const kMaxPoints = 4096;

/** Straight lines from tap to tap. */
export class LinesDrawing extends PointDrawing {
  get isReady(): boolean {
    return this.points.length >= 2;
  }

  get prompt(): string {
    if (!this.isStarted) return `${pressVerb()} the corners of a line of straight pieces`;
    return this.isReady ? `${pressVerb()} more corners, or cut` : `${pressVerb()} the next corner`;
  }

  override tap(point: Point2): void {
    if (this.points.length < kMaxPoints) this.points.push(point);
  }

  override removeLast(): boolean {
    return this.points.pop() !== undefined;
  }

  lines(): PreviewLine[] {
    return [{ points: this.points }];
  }

  cut(): DrawnCut {
    return { curve: { kind: { case: 'polyline', value: { points: this.points } } } };
  }
}
