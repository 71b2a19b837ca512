import type { Point2 } from '../geometry/locator';
import { CutHandles } from './cut_handles';
import type { HandleEvents } from './cut_handles';
import { CutPreview } from './cut_preview';
import type { DrawingPlane } from './drawing_plane';
import type { Drawing } from './drawings/drawing';
import { SheetPreview } from './sheet_preview';
import { stripAlong } from './strip_preview';
import type { Viewer } from './tool';

/** A drawing about to be cut, with all that affects how it is shown. */
export interface ShownDrawing {
  drawing: Drawing;
  plane: DrawingPlane;
  /** True if `plane` is the material, false if it is the picture. */
  isOnMaterial: boolean;
  /** Lengths of material cut and left in turn, metres; empty: everything is cut. */
  dashLengths: readonly number[];
  /** Width of the strip that the cut removes, metres of material. */
  widthM: number;
  /** Index of the chosen handle; -1: none */
  chosenHandle: number;
  /** Material point at which the chosen piece is marked; undefined: no mark. */
  mark: Point2 | undefined;
}

/** Shows a drawing over the picture or on the sheet, with its handles and the mark of the chosen piece. */
export class CutDisplay {
  private readonly marker = document.createElement('div');
  private readonly preview: CutPreview;
  private readonly sheetPreview = new SheetPreview();
  private readonly handles: CutHandles;

  constructor(
    private readonly viewer: Pick<Viewer, 'overlay' | 'stage' | 'shown'>,
    handleEvents: HandleEvents,
  ) {
    const { overlay, stage } = viewer;
    this.marker.className = 'piece-marker';
    this.marker.hidden = true;
    overlay.append(this.marker);
    this.preview = new CutPreview(overlay);
    stage.scene.add(this.sheetPreview.object);
    this.handles = new CutHandles(overlay, handleEvents);
  }

  /** Call it when the drawing, its dashes or its width may have changed. */
  changed(): void {
    this.sheetPreview.changed();
  }

  show(shown: ShownDrawing): void {
    this.showMark(shown.mark);
    if (shown.isOnMaterial) this.showOnSheet(shown);
    else this.showOnPicture(shown);
    const { plane, drawing, chosenHandle } = shown;
    this.handles.show(
      drawing.handles.map((point, i) => ({
        px: plane.toPx(point),
        text: drawing.handleText(i),
        isChosen: drawing.weights !== undefined && i === chosenHandle,
      })),
    );
  }

  private showMark(mark: Point2 | undefined): void {
    const world = mark && this.viewer.shown.surface?.toWorld(mark);
    const px = world && this.viewer.stage.project(world);
    this.marker.hidden = !px;
    if (px) this.marker.style.transform = `translate(${px.x.toFixed(1)}px, ${px.y.toFixed(1)}px)`;
  }

  private showOnSheet({ drawing, dashLengths, widthM }: ShownDrawing): void {
    const { surface } = this.viewer.shown;
    if (!surface) return this.sheetPreview.hide();
    this.preview.show([]);
    this.sheetPreview.show(surface, () => ({ lines: drawing.lines(), dashLengths, widthM }));
  }

  // Converts lengths to pixels as for a sheet seen face-on in the middle of the view.
  private showOnPicture({ drawing, plane, dashLengths, widthM }: ShownDrawing): void {
    const { stage } = this.viewer;
    this.sheetPreview.hide();
    const metresPerPx = stage.metresPerPx(stage.controls.target);
    const lines = drawing.lines();
    const dashPx = dashLengths.map((metres) => metres / metresPerPx);
    const curves = lines.filter((line) => !line.isGuide).map((line) => line.points);
    const strip = stripAlong(curves, widthM / metresPerPx, dashPx);
    const toPx = (point: Point2) => plane.toPx(point);
    this.preview.show(
      lines.map(({ points, isGuide }) => ({ points: points.map(toPx), isGuide })),
      dashPx,
      strip.map((polygon) => polygon.map(toPx)),
    );
  }
}
