import { distance, ellipsePoints } from '../../geometry/curve';
import type { Point2 } from '../../geometry/locator';
import { PointDrawing } from './drawing';
import type { DrawnCut, PreviewLine } from './drawing';

// Its chords are within 1/6000 of its larger diameter of the ellipse.
const kPreviewPieces = 128;
// The second axis of a new ellipse against the first.
const kFirstRatio = 0.6;

/**
 * A circle or an ellipse: a drag from the centre to the rim makes it. Points: centre, end of the first axis and, of an
 * ellipse, of the second one, which stays at a right angle to it.
 */
export class EllipseDrawing extends PointDrawing {
  private isDrawing = false;

  constructor(private readonly isCircle: boolean) {
    super();
  }

  get isReady(): boolean {
    return !this.isDrawing && this.points.length > 0;
  }

  get prompt(): string {
    const name = this.isCircle ? 'circle' : 'ellipse';
    if (this.isDrawing) return 'Let go at the rim';
    return this.isReady
      ? `Drag its points to adjust the ${name}, then cut`
      : `Press in the middle of the ${name} and drag to its rim`;
  }

  override get handles(): readonly Point2[] {
    return this.isDrawing ? [] : this.points;
  }

  override handleText(index: number): string {
    return index === 0 ? '✥' : '';
  }

  override press(point: Point2): boolean {
    // A finished shape is adjusted by its handles: a press beside it moves the view.
    if (this.points.length > 0) return false;
    this.isDrawing = true;
    this.points = this.isCircle ? [point, point] : [point, point, point];
    return true;
  }

  override drag(point: Point2): void {
    const [center] = this.points;
    this.points[1] = point;
    if (!this.isCircle) this.points[2] = this.beside(kFirstRatio * distance(center, point));
  }

  override release(tremor: number): void {
    this.isDrawing = false;
    if (distance(this.points[0], this.points[1]) < 2 * tremor) this.points = [];
  }

  override moveHandle(index: number, to: Point2): void {
    const [center, , second] = this.points;
    if (index === 0) {
      const [dx, dy] = [to.x - center.x, to.y - center.y];
      this.points = this.points.map(({ x, y }) => ({ x: x + dx, y: y + dy }));
    } else if (index === 1) {
      if (distance(center, to) === 0) return;
      const length = second && distance(center, second);
      this.points[1] = to;
      if (length !== undefined) this.points[2] = this.beside(length);
    } else {
      const length = distance(center, to);
      if (length > 0) this.points[2] = this.beside(length);
    }
  }

  // Elsewhere the axes may no longer be at a right angle.
  override map(move: (point: Point2) => Point2 | undefined): boolean {
    if (!super.map(move)) return false;
    const [center, , second] = this.points;
    if (second) this.points[2] = this.beside(distance(center, second));
    return true;
  }

  override removeLast(): boolean {
    const isAny = this.points.length > 0;
    this.points = [];
    return isAny;
  }

  lines(): PreviewLine[] {
    if (!this.isStarted) return [];
    const [center, rim] = this.points;
    const second = this.points[2] ?? this.beside(distance(center, rim));
    const spokes = this.points.slice(1).map((end) => ({ points: [center, end], isGuide: true }));
    return [...spokes, { points: ellipsePoints(center, rim, second, kPreviewPieces) }];
  }

  cut(): DrawnCut {
    const [center, rim, second] = this.points;
    const semiAxisXM = distance(center, rim);
    if (!second) return { curve: { kind: { case: 'circle', value: { center, radiusM: semiAxisXM } } } };
    const rotationRad = Math.atan2(rim.y - center.y, rim.x - center.x);
    const semiAxisYM = distance(center, second);
    return { curve: { kind: { case: 'ellipse', value: { center, semiAxisXM, semiAxisYM, rotationRad } } } };
  }

  // The point this far from the centre at a right angle to the first axis.
  private beside(length: number): Point2 {
    const [center, rim] = this.points;
    const scale = length / (distance(center, rim) || 1);
    return { x: center.x - scale * (rim.y - center.y), y: center.y + scale * (rim.x - center.x) };
  }
}
