import type { MessageInitShape } from '@bufbuild/protobuf';
import type { CutSchema } from '../../gen/kerf/v1/scene_pb';
import type { Point2 } from '../../geometry/locator';

/** Fields of a kerf.v1.Cut that a drawing sets. */
export type DrawnCut = Pick<MessageInitShape<typeof CutSchema>, 'curve' | 'fit' | 'joinM'>;

/** A line of the preview: a part of the curve to cut, or only a guide, such as a line to a control point. */
export interface PreviewLine {
  points: readonly Point2[];
  isGuide?: boolean;
}

/**
 * A curve that the user draws, adjusts and then cuts along. Its coordinates are those of the plane on which it lies:
 * pixels of the picture (y down) or metres of material (y up).
 */
export interface Drawing {
  /** Points that can be dragged. */
  readonly handles: readonly Point2[];
  /** Weights of the handles; undefined if the drawing has none. */
  readonly weights?: number[];
  readonly isStarted: boolean;
  readonly isReady: boolean;
  /** Prompt for the next step. */
  readonly prompt: string;
  /** Short text on a handle. */
  handleText(index: number): string;
  lines(): PreviewLine[];
  /** Returns the cut along the drawing; only if isReady. */
  cut(): DrawnCut;

  tap(point: Point2): void;
  /** Handles a press; true takes the gesture, so that drag() and release() follow. */
  press(point: Point2): boolean;
  drag(point: Point2): void;
  /** @param tremor  distance within which movements are unintentional, in the plane's unit */
  release(tremor: number): void;
  moveHandle(index: number, to: Point2): void;
  /** Removes the last point; false if there is none. */
  removeLast(): boolean;
  /** Moves every point by `move`; if one cannot be moved, returns false and moves none. */
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
