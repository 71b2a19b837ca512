import { BezierDrawing } from './bezier_drawing';
import type { Drawing } from './drawing';
import { EllipseDrawing } from './ellipse_drawing';
import { FreehandDrawing } from './freehand_drawing';
import { LinesDrawing } from './lines_drawing';
import { PictureDrawing } from './picture_drawing';

export type CutMode = 'curve' | 'lines' | 'freehand' | 'circle' | 'ellipse' | 'svg';

const kDrawings: Record<CutMode, () => Drawing> = {
  curve: () => new BezierDrawing(),
  lines: () => new LinesDrawing(),
  freehand: () => new FreehandDrawing(),
  circle: () => new EllipseDrawing(true),
  ellipse: () => new EllipseDrawing(false),
  svg: () => new PictureDrawing(),
};

/** Returns an empty drawing of this kind. */
export function newDrawing(mode: CutMode): Drawing {
  return kDrawings[mode]();
}
