import { Group } from 'three';
import type { Object3D } from 'three';
import type { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import type { Point2 } from '../geometry/locator';
import { dashes } from '../geometry/strip';
import type { Surface } from '../geometry/surface';
import { placePolygons, traceLines, writePositions } from '../geometry/trace';
import type { Places } from '../geometry/trace';
import { FatLines } from '../scene/fat_lines';
import { SheetFill } from '../scene/sheet_fill';
import type { PreviewLine } from './drawings/drawing';
import { stripAlong } from './strip_preview';

/** A drawing on the material, in material coordinates (m). */
export interface MaterialDrawing {
  lines: readonly PreviewLine[];
  /** Lengths cut and left in turn, metres; empty: everything is cut. */
  dashLengths: readonly number[];
  widthM: number;
}

interface Look {
  color: number;
  widthPx: number;
  rimPx: number;
}

// As in style/drawing.css.
const kRim = 0x10151c;
const kCurve: Look = { color: 0xffd23f, widthPx: 4, rimPx: 7 };
const kGuide: Look = { color: 0xffffff, widthPx: 2, rimPx: 4.5 };
// More lines than this are drawn thinner.
const kManyLines = 12;
const kFine = { widthPx: 1.5, rimPx: 3.5 };
const kFaint = 0.4;
const kStrip = { color: 0xe5383b, opacity: 0.55, faintOpacity: 0.2 };
// A line with more dashes than this is drawn whole, because they could not be distinguished.
const kMaxDashes = 5000;

/** Lines on the sheet with a dark rim, faint where a fold hides them. */
class SheetLines {
  private readonly lines: FatLines;
  private readonly rim: LineMaterial;
  private readonly core: LineMaterial;
  private readonly hidden: LineMaterial;
  private ends: Places | undefined;

  constructor(
    private readonly look: Look,
    order: number,
  ) {
    this.lines = new FatLines({ color: kRim, width: look.rimPx, part: 'seen' });
    this.lines.object.renderOrder = order;
    this.rim = this.lines.material;
    this.core = this.lines.addLook({ color: look.color, width: look.widthPx, part: 'seen' });
    this.hidden = this.lines.addLook({ color: look.color, width: look.widthPx, opacity: kFaint, part: 'hidden' });
  }

  get object(): Object3D {
    return this.lines.object;
  }

  set(lines: readonly (readonly Point2[])[], surface: Surface, isFine: boolean): void {
    this.ends = traceLines(lines, surface);
    const { widthPx, rimPx } = isFine ? kFine : this.look;
    this.rim.linewidth = rimPx;
    this.core.linewidth = this.hidden.linewidth = widthPx;
  }

  place({ mirror }: Surface): void {
    if (this.ends) writePositions(this.ends, mirror, this.lines.begin(this.ends.slots.length / 2));
  }
}

/** Shows on the moving sheet the curve about to be cut and the strip that the cut removes. */
export class SheetPreview {
  readonly object = new Group();
  // All are drawn over the floor: first the strip, then guides, then curves.
  private readonly strip = new SheetFill(kStrip.color, kStrip.opacity, kStrip.faintOpacity, 1);
  private readonly guides = new SheetLines(kGuide, 2);
  private readonly curves = new SheetLines(kCurve, 5);
  private corners: Places | undefined;
  private surface: Surface | undefined;
  private version = -1;

  constructor() {
    this.object.add(this.strip.object, this.guides.object, this.curves.object);
    this.object.visible = false;
  }

  /** Call it when the drawing has changed. */
  changed(): void {
    this.version = -1;
  }

  hide(): void {
    this.object.visible = false;
  }

  /**
   * Shows the drawing on the sheet's present shape.
   * @param read  called for the drawing if it or the triangles have changed
   */
  show(surface: Surface, read: () => MaterialDrawing): void {
    const { topologyVersion } = surface.mirror;
    if (surface !== this.surface || topologyVersion !== this.version) {
      this.lay(surface, read());
      [this.surface, this.version] = [surface, topologyVersion];
    }
    this.guides.place(surface);
    this.curves.place(surface);
    const { corners } = this;
    if (corners) writePositions(corners, surface.mirror, this.strip.begin(corners.slots.length));
    this.object.visible = true;
  }

  private lay(surface: Surface, { lines, dashLengths, widthM }: MaterialDrawing): void {
    const isFine = lines.length > kManyLines;
    const pointsOf = (areGuides: boolean) =>
      lines.filter((line) => (line.isGuide ?? false) === areGuides).map((line) => line.points);
    const curves = pointsOf(false);
    const isDashed = dashLengths.length > 0 && numDashes(curves, dashLengths) <= kMaxDashes;
    this.guides.set(pointsOf(true), surface, false);
    this.curves.set(isDashed ? dashes(curves, dashLengths) : curves, surface, isFine);
    this.corners = placePolygons(stripAlong(curves, widthM, isDashed ? dashLengths : []), surface);
  }
}

function numDashes(lines: readonly (readonly Point2[])[], lengths: readonly number[]): number {
  const along = (line: readonly Point2[]) =>
    line.slice(1).reduce((sum, to, i) => sum + Math.hypot(to.x - line[i].x, to.y - line[i].y), 0);
  return lines.reduce((sum, line) => sum + along(line), 0) / lengths.reduce((sum, length) => sum + length, 0);
}
