import { bezierPoint } from '../../geometry/curve';
import type { Point2 } from '../../geometry/locator';
import { pressVerb } from '../press_verb';
import { PointDrawing } from './drawing';
import type { DrawnCut, PreviewLine } from './drawing';

const kPreviewPieces = 64;

/**
 * A Bezier curve by its control points: three taps make it quadratic, a fourth cubic. Rational where weights differ.
 */
export class BezierDrawing extends PointDrawing {
  readonly weights: number[] = [];

  get isReady(): boolean {
    return this.points.length >= 3;
  }

  get prompt(): string {
    switch (this.points.length) {
      case 0:
        return `${pressVerb()} the points of a curve: three or four`;
      case 3:
        return `Cut this quadratic curve, or ${pressVerb().toLowerCase()} a fourth point for a cubic one`;
      case 4:
        return `Drag the points, ${pressVerb().toLowerCase()} one to weight it, then cut`;
      default:
        return `Point ${this.points.length + 1} of 3 or 4`;
    }
  }

  override tap(point: Point2): void {
    if (this.points.length >= 4) return;
    this.points.push(point);
    this.weights.push(1);
  }

  override removeLast(): boolean {
    this.weights.pop();
    return this.points.pop() !== undefined;
  }

  lines(): PreviewLine[] {
    if (!this.isReady) return [{ points: this.points }];
    const { points, weights } = this;
    const at = (i: number) => bezierPoint(points, i / kPreviewPieces, weights);
    const curve = Array.from({ length: kPreviewPieces + 1 }, (_, i) => at(i));
    return [{ points, isGuide: true }, { points: curve }];
  }

  cut(): DrawnCut {
    const [start, ...rest] = this.points;
    // Weights have a meaning only by their ratios.
    const weights = this.weights.every((weight) => weight === this.weights[0]) ? [] : this.weights;
    const segment =
      rest.length === 2
        ? { kind: { case: 'quadratic' as const, value: { control: rest[0], end: rest[1], weights } } }
        : {
            kind: { case: 'cubic' as const, value: { control1: rest[0], control2: rest[1], end: rest[2], weights } },
          };
    return { curve: { kind: { case: 'path', value: { subpaths: [{ start, segments: [segment] }] } } } };
  }
}
