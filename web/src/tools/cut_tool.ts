import { create } from '@bufbuild/protobuf';
import type { Vector2 } from 'three';
import { call } from '../api';
import { CutResult_Status, CutService } from '../gen/kerf/v1/cuts_pb';
import { CurveSchema } from '../gen/kerf/v1/geometry_pb';
import type { Curve } from '../gen/kerf/v1/geometry_pb';
import { bezierPoint, simplify } from '../geometry/curve';
import type { Point2 } from '../geometry/locator';
import { CutHandles } from './cut_handles';
import { CutPreview } from './cut_preview';
import { cutText } from './cut_text';
import type { Pointer, Tool, Viewer } from './tool';

export type CutMode = 'bezier' | 'freehand';

const kPreviewPieces = 64;
// How far the cut may leave the stroke, in parts of the sheet's diagonal: less than a hand's tremor.
const kFreehandTolerance = 0.002;

/**
 * Draws a curve on the sheet, in material coordinates so that it moves with the sheet, and cuts along it: four taps for
 * the control points of a cubic Bezier curve, or one stroke for a polyline. A point beside the sheet is allowed, so
 * that a cut can run from border to border.
 */
export class CutTool implements Tool {
  readonly id = 'cut';
  readonly cursor = 'crosshair';
  private points: Point2[] = [];
  private isDrawing = false;
  private isCutting = false;
  private currentMode: CutMode = 'bezier';
  private readonly preview: CutPreview;
  private readonly handles: CutHandles;

  /** @param changed  called when the prompt or the possible actions may have changed */
  constructor(
    private readonly viewer: Viewer,
    private readonly changed: () => void,
  ) {
    this.preview = new CutPreview(viewer.stage);
    this.handles = new CutHandles(viewer.overlay, (index, px) => this.moveHandle(index, px));
  }

  get mode(): CutMode {
    return this.currentMode;
  }

  setMode(mode: CutMode): void {
    this.currentMode = mode;
    this.cancel();
  }

  get isReady(): boolean {
    return !this.isCutting && !this.isDrawing && this.points.length >= (this.mode === 'bezier' ? 4 : 2);
  }

  get isStarted(): boolean {
    return this.points.length > 0;
  }

  get prompt(): string {
    if (this.isReady) return this.mode === 'bezier' ? 'Drag the points to adjust, then cut' : 'Cut along the line?';
    if (this.mode === 'freehand') return 'Draw a line across the sheet';
    return this.isStarted
      ? `Point ${this.points.length + 1} of 4`
      : 'Tap four points; start and end beside the sheet to cut through';
  }

  enter(): void {
    this.changed();
  }

  leave(): void {
    this.cancel();
  }

  press(pointer: Pointer): boolean {
    if (this.mode !== 'freehand') return false;
    const point = this.materialAt(pointer);
    if (!point) return false;
    this.points = [point];
    this.isDrawing = true;
    this.refresh();
    return true;
  }

  drag(pointer: Pointer): void {
    if (!this.isDrawing) return;
    const point = this.materialAt(pointer);
    if (point) this.points.push(point);
    this.refresh();
  }

  release(): void {
    this.isDrawing = false;
    const { locator } = this.viewer.surface ?? {};
    if (locator && this.points.length > 1) {
      const size = Math.hypot(locator.max.x - locator.min.x, locator.max.y - locator.min.y);
      this.points = simplify(this.points, kFreehandTolerance * size);
    }
    if (this.points.length < 2) this.points = [];
    this.refresh();
  }

  tap(pointer: Pointer): void {
    if (this.mode !== 'bezier' || this.points.length >= 4) return;
    const point = this.materialAt(pointer);
    if (point) this.points.push(point);
    this.refresh();
  }

  key(key: string): boolean {
    if (key === 'Enter' && this.isReady) void this.cut();
    else if (key === 'Escape' && this.isStarted) this.cancel();
    else if (key === 'Backspace' && this.isStarted && this.mode === 'bezier') this.points.pop();
    else return false;
    this.refresh();
    return true;
  }

  cancel(): void {
    this.points = [];
    this.isDrawing = false;
    this.refresh();
  }

  async cut(): Promise<void> {
    if (!this.isReady) return;
    this.isCutting = true;
    this.refresh();
    const result = await this.viewer.attempt(() =>
      call(CutService.method.createCut, { parent: this.viewer.sheetName, cut: { curve: this.curve() } }),
    );
    this.isCutting = false;
    if (result) {
      this.viewer.notify(result.status === CutResult_Status.APPLIED ? 'success' : 'info', cutText(result));
      this.points = [];
    }
    this.refresh();
  }

  update(): void {
    const { surface, stage } = this.viewer;
    if (!surface || !this.isStarted) {
      this.preview.clear();
      this.handles.show([]);
      return;
    }
    const toWorld = (point: Point2) => surface.toWorld(point);
    const isBezier = this.mode === 'bezier';
    const isCurve = isBezier && this.points.length === 4;
    const line = isCurve
      ? Array.from({ length: kPreviewPieces + 1 }, (_, i) => bezierPoint(this.points, i / kPreviewPieces))
      : this.points;
    this.preview.show(line.map(toWorld), isCurve ? this.points.map(toWorld) : []);
    this.handles.show(
      isBezier
        ? this.points.map((point) => {
            const world = toWorld(point);
            return world && stage.project(world);
          })
        : [],
    );
  }

  private curve(): Curve {
    return create(
      CurveSchema,
      this.mode === 'bezier'
        ? { kind: { case: 'bezier', value: { points: this.points } } }
        : { kind: { case: 'polyline', value: { points: this.points } } },
    );
  }

  private materialAt({ px, ray }: Pointer): Point2 | undefined {
    const { surface, stage } = this.viewer;
    return (
      surface?.pick(ray)?.material ?? surface?.pickBeside(px, stage.camera, stage.sizePx, (at) => stage.metresPerPx(at))
    );
  }

  private moveHandle(index: number, px: Vector2): void {
    const point = this.materialAt({ px, ray: this.viewer.stage.rayAt(px) });
    if (point && index < this.points.length) this.points[index] = point;
    this.refresh();
  }

  private refresh(): void {
    this.viewer.stage.invalidate();
    this.changed();
  }
}
