import type { MessageInitShape } from '@bufbuild/protobuf';
import type { CutSchema } from '../../gen/kerf/v1/scene_pb';
import type { Point2 } from '../../geometry/locator';

/** Fields of a kerf.v1.Cut that a drawing decides. */
export type DrawnCut = Pick<MessageInitShape<typeof CutSchema>, 'curve' | 'fit'>;

/** A line for the preview, and whether it is what is cut or only leads to it. */
export interface PreviewLine {
  points: readonly Point2[];
  isGuide?: boolean;
}

/**
 * Something that is drawn, adjusted and then cut along, in the coordinates of the plane that it lies on: pixels of the
 * picture (y down) or metres of material (y up).
 */
export interface Drawing {
  /** Points that can be dragged. */
  readonly handles: readonly Point2[];
  /** Weights of the handles, where they can be changed. */
  readonly weights?: number[];
  readonly isStarted: boolean;
  readonly isReady: boolean;
  /** Prompt for the next step. */
  readonly prompt: string;
  /** Short text on a handle. */
  handleText(index: number): string;
  lines(): PreviewLine[];
  /** Only when ready. */
  cut(): DrawnCut;

  tap(point: Point2): void;
  /** A press; true takes the gesture, which drag() and release() follow. */
  press(point: Point2): boolean;
  drag(point: Point2): void;
  /** @param tremor  how far a hand strays without meaning it, in the plane's unit */
  release(tremor: number): void;
  moveHandle(index: number, to: Point2): void;
  /** Takes the last point back; false if there is none to take. */
  removeLast(): boolean;
  /** Moves every point; false, and nothing is moved, if one of them cannot be. */
  map(move: (point: Point2) => Point2 | undefined): boolean;
}

/** A drawing that is made of points only. */
export abstract class PointDrawing implements Drawing {
  protected points: Point2[] = [];
  abstract readonly isReady: boolean;
  abstract readonly prompt: string;

  get handles(): readonly Point2[] {
    return this.points;
  }

  get isStarted(): boolean {
    return this.points.length > 0;
  }

  handleText(index: number): string {
    return String(index + 1);
  }

  abstract lines(): PreviewLine[];
  abstract cut(): DrawnCut;

  tap(_point: Point2): void {}

  press(_point: Point2): boolean {
    return false;
  }

  drag(_point: Point2): void {}
  release(_tremor: number): void {}

  moveHandle(index: number, to: Point2): void {
    this.points[index] = to;
  }

  removeLast(): boolean {
    return false;
  }

  map(move: (point: Point2) => Point2 | undefined): boolean {
    const moved = this.points.map(move);
    if (!moved.every((point) => point !== undefined)) return false;
    this.points = moved;
    return true;
  }
}
