import type { DrawingReport } from '../../gen/kerf/v1/files_pb';
import type { Point2 } from '../../geometry/locator';
import type { SvgOutline } from '../../geometry/svg_outline';
import type { DrawnCut, Drawing, PreviewLine } from './drawing';
import type { DrawingContent } from './drawing_content';

export interface Picture {
  name: string;
  content: DrawingContent;
  /** Selector of the shapes that are cut, such as "stroke=red"; empty: all. */
  only?: string;
  /** The server's word on it. */
  report?: DrawingReport;
  /** Undefined if there is nothing to show. */
  outline: SvgOutline | undefined;
}

export interface Box {
  min: Point2;
  max: Point2;
}

// Share of the sheet's box left free at each side, as by the server.
const kMargin = 0.05;
// Number of straight pieces of each side of the box, so that it follows the sheet.
const kSidePieces = 16;
// Ends of lines are joined within this share of the drawing's size.
const kJoin = 1e-3;
// Least side of the box, as a share of the sheet's larger side.
const kLeastSide = 0.01;

/**
 * An SVG file in a box on the material, which the user moves and scales before the cut. It is empty until a file is
 * given.
 */
export class PictureDrawing implements Drawing {
  private box: Box = { min: { x: 0, y: 0 }, max: { x: 0, y: 0 } };
  private aspect: number = 1;
  private readonly leastSide: number = 0;
  private held: Point2 | undefined;

  /** @param sheet  the sheet's bounding box, metres; required with a picture */
  constructor(
    private shownPicture?: Picture,
    sheet?: Box,
  ) {
    const picture = shownPicture;
    if (!picture || !sheet) return;
    const [width, height] = [sheet.max.x - sheet.min.x, sheet.max.y - sheet.min.y];
    this.aspect = picture.outline?.aspect ?? width / height;
    this.leastSide = kLeastSide * Math.max(width, height);
    const fitted = Math.min(width, height * this.aspect) * (1 - 2 * kMargin);
    const half = { x: 0.5 * fitted, y: (0.5 * fitted) / this.aspect };
    const center = { x: 0.5 * (sheet.min.x + sheet.max.x), y: 0.5 * (sheet.min.y + sheet.max.y) };
    this.box = {
      min: { x: center.x - half.x, y: center.y - half.y },
      max: { x: center.x + half.x, y: center.y + half.y },
    };
  }

  get picture(): Picture | undefined {
    return this.shownPicture;
  }

  get report(): DrawingReport | undefined {
    return this.picture?.report;
  }

  get only(): string {
    return this.picture?.only ?? '';
  }

  /** Shows another part of the same file; its box keeps its middle and the scale of what was shown. */
  replace(picture: Picture): void {
    const before = trueSize(this.report);
    const after = trueSize(picture.report);
    const scale = before && after ? (this.box.max.x - this.box.min.x) / before.width : 0;
    this.shownPicture = picture;
    this.aspect = picture.outline?.aspect ?? this.aspect;
    if (scale > 0 && after) this.resize(scale * after.width);
    else this.resize(this.box.max.x - this.box.min.x);
  }

  /** Gives the drawing its own size, about its middle. */
  takeTrueSize(): void {
    const size = trueSize(this.report);
    if (size) this.resize(size.width);
  }

  get isStarted(): boolean {
    return this.picture !== undefined;
  }

  get isReady(): boolean {
    return this.isStarted;
  }

  get prompt(): string {
    if (!this.picture) return 'Drop an SVG or DXF file on the sheet, or choose one';
    return this.picture.outline
      ? `Drag ${this.picture.name} where it is to be cut, or its corners to scale it`
      : `No outline of ${this.picture.name} can be shown here; the server may find one`;
  }

  /** Corners, counter-clockwise from the lower left one, and the middle. */
  get handles(): readonly Point2[] {
    if (!this.isStarted) return [];
    const { min, max } = this.box;
    return [min, { x: max.x, y: min.y }, max, { x: min.x, y: max.y }, middle(this.box)];
  }

  handleText(index: number): string {
    return index === 4 ? '✥' : '';
  }

  lines(): PreviewLine[] {
    if (!this.isStarted) return [];
    const { min, max } = this.box;
    const corners = this.handles.slice(0, 4);
    const border = corners.flatMap((from, i) => {
      const to = corners[(i + 1) % 4];
      return Array.from({ length: kSidePieces }, (_, k) => between(from, to, k / kSidePieces));
    });
    const outlines = (this.picture?.outline?.lines ?? []).map((line) => ({
      points: line.map(({ x, y }) => ({ x: min.x + x * (max.x - min.x), y: min.y + y * (max.y - min.y) })),
    }));
    return [{ points: [...border, border[0]], isGuide: true }, ...outlines];
  }

  cut(): DrawnCut {
    const { min, max } = this.box;
    const { content } = this.picture!;
    const value = { ...content.value, reading: this.only ? { only: [this.only] } : undefined };
    return {
      curve: { kind: { case: content.case, value } as never },
      fit: { min, max },
      joinM: kJoin * Math.max(max.x - min.x, max.y - min.y),
    };
  }

  tap(): void {}

  press(point: Point2): boolean {
    const { min, max } = this.box;
    const isInside = point.x >= min.x && point.x <= max.x && point.y >= min.y && point.y <= max.y;
    if (!this.isStarted || !isInside) return false;
    this.held = point;
    return true;
  }

  drag(point: Point2): void {
    if (this.held) this.shift(point.x - this.held.x, point.y - this.held.y);
    this.held = point;
  }

  release(): void {
    this.held = undefined;
  }

  moveHandle(index: number, to: Point2): void {
    if (index === 4) {
      const from = middle(this.box);
      return this.shift(to.x - from.x, to.y - from.y);
    }
    // The opposite corner and the proportions of the box stay.
    const opposite = this.handles[(index + 2) % 4];
    const isRight = index === 1 || index === 2;
    const isUpper = index === 2 || index === 3;
    const reachX = (to.x - opposite.x) * (isRight ? 1 : -1);
    const reachY = (to.y - opposite.y) * (isUpper ? 1 : -1);
    const width = Math.max(reachX, reachY * this.aspect, this.leastSide * Math.max(1, this.aspect));
    const height = width / this.aspect;
    const min = { x: isRight ? opposite.x : opposite.x - width, y: isUpper ? opposite.y : opposite.y - height };
    this.box = { min, max: { x: min.x + width, y: min.y + height } };
  }

  removeLast(): boolean {
    return false;
  }

  // Always fails, because an SVG drawing can only lie on the material.
  map(): boolean {
    return false;
  }

  private resize(width: number): void {
    const center = middle(this.box);
    const half = { x: 0.5 * width, y: (0.5 * width) / this.aspect };
    this.box = {
      min: { x: center.x - half.x, y: center.y - half.y },
      max: { x: center.x + half.x, y: center.y + half.y },
    };
  }

  private shift(dx: number, dy: number): void {
    const { min, max } = this.box;
    this.box = { min: { x: min.x + dx, y: min.y + dy }, max: { x: max.x + dx, y: max.y + dy } };
  }
}

// Returns the size of the lines to cut, metres. A straight line has a thin box, as in its outline.
function trueSize(report: DrawingReport | undefined): { width: number } | undefined {
  if (!report?.min || !report.max || report.lines === 0) return undefined;
  const [width, height] = [report.max.x - report.min.x, report.max.y - report.min.y];
  return { width: Math.max(width, 1e-3 * height) };
}

function middle({ min, max }: Box): Point2 {
  return between(min, max, 0.5);
}

function between(from: Point2, to: Point2, t: number): Point2 {
  return { x: (1 - t) * from.x + t * to.x, y: (1 - t) * from.y + t * to.y };
}
