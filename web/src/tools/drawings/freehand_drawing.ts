import { bezierPoint, distance, flattened } from '../../geometry/curve';
import { fitCurve } from '../../geometry/curve_fit';
import type { Cubic } from '../../geometry/curve_fit';
import type { Point2 } from '../../geometry/locator';
import { PointDrawing } from './drawing';
import type { DrawnCut, PreviewLine } from './drawing';

// Most points of a stroke that are kept.
const kMaxPoints = 4096;
// A stroke is closed if it ends within this many tremors of its start and went more than three times as far away.
const kClosingTremors = 8;
// Largest distance of the preview from the curve, in tremors.
const kPreviewTremors = 0.2;
const kMaxDepth = 9;

/** One stroke of the hand: a smooth curve within its tremor, with the corners that were drawn. */
export class FreehandDrawing extends PointDrawing {
  private isDrawing = false;
  private pieces: readonly Cubic[] = [];
  private tremor = 0;

  override get handles(): readonly Point2[] {
    return [];
  }

  get isReady(): boolean {
    return !this.isDrawing && this.pieces.length > 0;
  }

  get prompt(): string {
    if (!this.isReady) return 'Draw a line; end it where it began to cut a piece out';
    return this.isClosed ? 'Cut the loop, or draw another' : 'Cut the line, or draw another';
  }

  override press(point: Point2): boolean {
    this.points = [point];
    this.pieces = [];
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
    this.tremor = tremor;
    const [first] = this.points;
    const reach = kClosingTremors * tremor;
    const isLoop = distance(first, this.points[this.points.length - 1]) < reach;
    if (isLoop && this.points.some((point) => distance(first, point) > 3 * reach)) {
      // Removes points near the start: if the end crossed the start, the cut would separate a sliver.
      while (distance(first, this.points[this.points.length - 1]) < reach) this.points.pop();
      this.points.push(first);
    }
    if (this.points.every((point) => distance(first, point) < tremor)) this.points = [];
    this.fit();
  }

  override map(move: (point: Point2) => Point2 | undefined): boolean {
    const before = length(this.points);
    if (!super.map(move)) return false;
    // The tremor is a length of the new plane.
    if (before > 0) this.tremor *= length(this.points) / before;
    this.fit();
    return true;
  }

  lines(): PreviewLine[] {
    if (!this.isReady) return [{ points: this.points }];
    const flatness = { tolerance: kPreviewTremors * this.tremor, depth: kMaxDepth };
    const bends = this.pieces.map((piece) => flattened((t) => bezierPoint(piece, t), flatness));
    return [{ points: [bends[0][0], ...bends.flatMap((points) => points.slice(1))] }];
  }

  cut(): DrawnCut {
    const segments = this.pieces.map(([, control1, control2, end]) => {
      return { kind: { case: 'cubic' as const, value: { control1, control2, end } } };
    });
    const subpaths = [{ start: this.pieces[0][0], segments, closed: this.isClosed }];
    return { curve: { kind: { case: 'path', value: { subpaths } } } };
  }

  private fit(): void {
    this.pieces = this.isDrawing ? [] : fitCurve(this.points, this.tremor);
  }

  private get isClosed(): boolean {
    const [first] = this.points;
    const last = this.points[this.points.length - 1];
    return this.points.length > 2 && first.x === last.x && first.y === last.y;
  }
}

function length(points: readonly Point2[]): number {
  return points.slice(1).reduce((sum, point, i) => sum + distance(points[i], point), 0);
}
