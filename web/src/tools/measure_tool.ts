import type { Vector2 } from 'three';
import type { Point2 } from '../geometry/locator';
import { FatLines } from '../scene/fat_lines';
import { CutHandles } from './cut_handles';
import { lineMeasures, pieceMeasures } from './measures';
import type { LineMeasures, PieceMeasures } from './measures';
import { SheetPreview } from './sheet_preview';
import type { Pointer, Tool, Viewer } from './tool';

/** The numbers that the tool shows. */
export interface Measured {
  /** Number of points that are set, 0..2. */
  numPoints: number;
  /** True if a point is where the sheet was cut away. */
  isGone: boolean;
  line: LineMeasures | undefined;
  piece: PieceMeasures | undefined;
}

/**
 * Measures between two points of the sheet, which stay on their threads as it moves: the distance in space, the distance
 * on the undeformed sheet, and the area of the first point's piece. A third tap begins again.
 */
export class MeasureTool implements Tool {
  readonly id = 'measure';
  readonly cursor = 'crosshair';

  private points: Point2[] = [];
  private readonly handles: CutHandles;
  private readonly straight = new FatLines({ color: 0x10151c, width: 5, onTop: true });
  private readonly laid = new SheetPreview();
  private isChosen = false;

  /** @param measured  called before each drawing while the tool is chosen */
  constructor(
    private readonly viewer: Pick<Viewer, 'overlay' | 'stage' | 'shown'>,
    private readonly measured: (measured: Measured) => void,
  ) {
    this.handles = new CutHandles(viewer.overlay, {
      onChosen: () => {},
      onMoved: (index, px) => this.move(index, px),
      onTapped: (px) => this.tap({ px, ray: viewer.stage.rayAt(px) }),
    });
    this.straight.addLook({ color: 0x6fd3ff, width: 2.5, onTop: true });
    this.straight.begin(0);
    viewer.stage.scene.add(this.straight.object, this.laid.object);
  }

  enter(): void {
    this.isChosen = true;
    this.viewer.stage.invalidate();
    this.update();
  }

  leave(): void {
    this.isChosen = false;
    this.points = [];
    this.update();
    this.viewer.stage.invalidate();
  }

  press(): boolean {
    return false;
  }

  drag(): void {}
  release(): void {}
  abandon(): void {}

  tap(pointer: Pointer): void {
    const material = this.viewer.shown.surface?.pick(pointer.ray)?.material;
    if (!material) return;
    this.points = this.points.length < 2 ? [...this.points, material] : [material];
    this.changed();
  }

  /** Removes the points; false if there are none. */
  escape(): boolean {
    if (this.points.length === 0) return false;
    this.points = [];
    this.changed();
    return true;
  }

  update(): void {
    const { surface } = this.viewer.shown;
    const { points } = this;
    const places = points.map((point) => surface?.onSheet(point));
    this.handles.show(
      places.map((world, i) => ({ px: world && this.viewer.stage.project(world), text: 'AB'[i], isChosen: false })),
    );
    const [from, to] = places;
    this.straight.setPolyline(from && to ? [...from.toArray(), ...to.toArray()] : []);
    if (surface && from && to) {
      this.laid.show(surface, () => ({ lines: [{ points, isGuide: true }], dashLengths: [], widthM: 0 }));
    } else {
      this.laid.hide();
    }
    if (!this.isChosen) return;
    this.measured({
      numPoints: points.length,
      isGone: places.includes(undefined),
      line: surface && points.length === 2 ? lineMeasures(surface, points[0], points[1]) : undefined,
      piece: surface && points.length > 0 ? pieceMeasures(surface, points[0]) : undefined,
    });
  }

  private move(index: number, px: Vector2): void {
    const material = this.viewer.shown.surface?.pick(this.viewer.stage.rayAt(px))?.material;
    if (!material || index >= this.points.length) return;
    this.points[index] = material;
    this.changed();
  }

  private changed(): void {
    this.laid.changed();
    this.viewer.stage.invalidate();
  }
}
