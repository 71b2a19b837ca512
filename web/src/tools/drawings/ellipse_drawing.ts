import { distance, ellipsePoints } from '../../geometry/curve';
import type { Point2 } from '../../geometry/locator';
import { PointDrawing } from './drawing';
import type { DrawnCut, PreviewLine } from './drawing';

// Chords of the preview, which differ from the ellipse by at most 1/6000 of its larger diameter.
const kPreviewPieces = 128;
// Ratio of the second to the first axis of a new ellipse.
const kFirstRatio = 0.6;

/**
 * A circle or an ellipse, made by a drag from the centre to the rim. Its points are the centre, the end of the first
 * axis and, for an ellipse, the end of the second axis. The axes stay at a right angle.
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
    // A finished shape is adjusted by its handles only, so that a press beside them moves the view.
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

  // Makes the axes perpendicular again, which `move` may have changed.
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

  // Returns the point at this distance from the centre, perpendicular to the first axis.
  private beside(length: number): Point2 {
    const [center, rim] = this.points;
    const scale = length / (distance(center, rim) || 1);
    return { x: center.x - scale * (rim.y - center.y), y: center.y + scale * (rim.x - center.x) };
  }
}
