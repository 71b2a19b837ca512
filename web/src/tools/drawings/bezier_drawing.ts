import { bezierPoint, flattened } from '../../geometry/curve';
import type { Point2 } from '../../geometry/locator';
import { pressVerb } from '../press_verb';
import { PointDrawing } from './drawing';
import type { DrawnCut, PreviewLine } from './drawing';

// Largest distance of the preview from the curve, as a share of the longer side of the box around the curve's points.
const kTolerance = 2e-4;
const kMaxDepth = 9;

/**
 * A Bezier curve given by its control points: quadratic after three taps, cubic after a fourth. It is rational if
 * weights differ.
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
    const extent = (along: (point: Point2) => number) => {
      const places = points.map(along);
      return Math.max(...places) - Math.min(...places);
    };
    const tolerance = kTolerance * Math.max(extent(({ x }) => x), extent(({ y }) => y));
    const curve = flattened((t) => bezierPoint(points, t, weights), { tolerance, depth: kMaxDepth });
    return [{ points, isGuide: true }, { points: curve }];
  }

  cut(): DrawnCut {
    const [start, ...rest] = this.points;
    // Only the ratios of weights matter, so equal weights are left out.
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
