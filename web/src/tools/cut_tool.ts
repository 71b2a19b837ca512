import type { MessageInitShape } from '@bufbuild/protobuf';
import { Vector2 } from 'three';
import { call } from '../api';
import { CutResult_Status, CutService } from '../gen/kerf/v1/cuts_pb';
import type { CutSchema } from '../gen/kerf/v1/scene_pb';
import type { Point2 } from '../geometry/locator';
import { svgOutline } from '../geometry/svg_outline';
import { CutForecast } from './cut_forecast';
import { CutHandles } from './cut_handles';
import { CutPreview } from './cut_preview';
import { cutDetails, cutText, warningText } from './cut_text';
import { MaterialPlane, PicturePlane, cutView, frontHalf } from './drawing_plane';
import type { CutTarget, DepthRange, DrawingPlane } from './drawing_plane';
import type { Drawing } from './drawings/drawing';
import { newDrawing } from './drawings/kinds';
import type { CutMode } from './drawings/kinds';
import { PictureDrawing } from './drawings/picture_drawing';
import type { Picture } from './drawings/picture_drawing';
import { pressVerb } from './press_verb';
import { SheetPreview } from './sheet_preview';
import { stripAlong } from './strip_preview';
import type { Pointer, Tool, Viewer } from './tool';

/** Perforation: metres of the sheet that are cut and left in turn. */
export interface Dashes {
  isOn: boolean;
  cutM: number;
  leftM: number;
}

/** Weights go from this to its inverse, and a key makes a step of them. */
export const kLeastWeight = 0.05;
const kWeightStep = 1.25;

/**
 * Draws something and cuts along it: what is seen under it on the picture or, if asked, the material, with which the
 * drawing then moves. It need not stay on the sheet: a cut from border to border starts and ends beside it.
 */
export class CutTool implements Tool {
  readonly id = 'cut';
  readonly cursor = 'crosshair';
  readonly dashes: Dashes = { isOn: false, cutM: 0.02, leftM: 0.01 };
  readonly depth: DepthRange = { nearestM: 0, farthestM: 0 };
  private currentWidthM = 0;
  private currentMode: CutMode = 'curve';
  private currentTarget: CutTarget = 'seen';
  private drawing: Drawing = newDrawing('curve');
  private chosenHandle = -1;
  private readonly underWay = new Set<Drawing>(); // being cut; meanwhile another may be drawn and cut
  private isChoosing = false;
  // Material point of the chosen piece: its label may be another one after each cut.
  private pieceMark: Point2 | undefined;
  private last: { drawing: Drawing; mode: CutMode; target: CutTarget; sizePx: Vector2 } | undefined;
  private readonly picture = new PicturePlane();
  private readonly material: MaterialPlane;
  private readonly preview: CutPreview;
  private readonly sheetPreview = new SheetPreview();
  private readonly forecast: CutForecast;
  private readonly handles: CutHandles;
  private readonly marker = document.createElement('div');
  private readonly drawnSizePx = new Vector2();

  /** @param changed  called when the prompt or the possible actions may have changed */
  constructor(
    private readonly viewer: Viewer,
    private readonly changed: () => void,
  ) {
    this.material = new MaterialPlane(viewer);
    this.marker.className = 'piece-marker';
    this.marker.hidden = true;
    viewer.overlay.append(this.marker);
    this.preview = new CutPreview(viewer.overlay);
    viewer.stage.scene.add(this.sheetPreview.object);
    this.forecast = new CutForecast(changed);
    this.handles = new CutHandles(
      viewer.overlay,
      (index) => this.chooseHandle(index),
      (index, px) => this.moveHandle(index, px),
    );
  }

  get mode(): CutMode {
    return this.currentMode;
  }

  setMode(mode: CutMode): void {
    this.currentMode = mode;
    this.cancel();
  }

  /** Lays a drawing on the sheet; false while there is none. */
  lay(picture: Omit<Picture, 'outline'>): boolean {
    const { locator } = this.viewer.surface ?? {};
    if (!locator) return false;
    this.setMode('svg');
    this.drawing = new PictureDrawing({ ...picture, outline: svgOutline(picture.text) }, locator);
    this.refresh();
    return true;
  }

  /** A drawing of a file lies on the material. */
  get target(): CutTarget {
    return this.currentMode === 'svg' ? 'material' : this.currentTarget;
  }

  /** Whether a piece was chosen by a tap; otherwise that is cut which is seen where the line first meets the sheet. */
  get hasPiece(): boolean {
    return this.pieceMark !== undefined;
  }

  /** The next tap chooses the piece; where one is chosen, it is forgotten. */
  choosePiece(): void {
    this.isChoosing = !this.isChoosing && !this.hasPiece;
    this.pieceMark = undefined;
    this.refresh();
  }

  get hasLast(): boolean {
    return this.last !== undefined && !this.isStarted;
  }

  /** Lays the drawing that was cut last again: where it was on the picture or on the material. */
  again(): void {
    if (!this.hasLast) return;
    const { drawing, mode, target, sizePx } = this.last!;
    this.currentMode = mode;
    this.currentTarget = target;
    this.drawing = drawing;
    this.drawnSizePx.copy(sizePx);
    this.refresh();
  }

  /** A drawing that is started is taken along to where it lies now. */
  setTarget(target: CutTarget): void {
    const from = this.plane;
    this.currentTarget = target;
    this.isChoosing = false;
    if (target === 'depth' && this.viewer.surface) Object.assign(this.depth, frontHalf(this.viewer.surface, this.viewer.stage.camera));
    const to = this.plane;
    const isKept = from === to || this.drawing.map((point) => {
      const px = from.toPx(point);
      return px && to.at(px);
    });
    if (!isKept) this.cancel();
    this.refresh();
  }

  get isReady(): boolean {
    return !this.underWay.has(this.drawing) && this.drawing.isReady;
  }

  get isStarted(): boolean {
    return this.drawing.isStarted;
  }

  /** True while a drawing lies on the sheet as it hangs. */
  get isOnSheet(): boolean {
    return this.isStarted && this.target === 'material';
  }

  get prompt(): string {
    return this.isChoosing ? `${pressVerb()} the piece to cut` : this.drawing.prompt;
  }

  /** Says that the cut would end real time, and at what cost; else empty. */
  get warning(): string {
    return this.forecast.warning;
  }

  /** The chosen point that has a weight. */
  get weighted(): { index: number; weight: number } | undefined {
    const weight = this.drawing.isReady ? this.drawing.weights?.[this.chosenHandle] : undefined;
    return weight === undefined ? undefined : { index: this.chosenHandle, weight };
  }

  setWeight(weight: number): void {
    if (!this.weighted) return;
    this.drawing.weights![this.chosenHandle] = Math.min(1 / kLeastWeight, Math.max(kLeastWeight, weight));
    this.refresh();
  }

  setDashes(dashes: Partial<Dashes>): void {
    Object.assign(this.dashes, dashes);
    this.refresh();
  }

  /** Of the strip that is taken away, metres of the sheet; 0: none. */
  get widthM(): number {
    return this.currentWidthM;
  }

  setWidth(metres: number): void {
    this.currentWidthM = Math.max(0, metres);
    this.refresh();
  }

  setDepth(depth: Partial<DepthRange>): void {
    Object.assign(this.depth, depth);
    this.refresh();
  }

  enter(): void {
    this.changed();
  }

  leave(): void {
    this.isChoosing = false;
    this.pieceMark = undefined;
    this.cancel();
    // Nobody else takes it off the canvas.
    this.update();
  }

  press(pointer: Pointer): boolean {
    if (this.isChoosing) return false;
    const point = this.plane.at(pointer.px);
    const isTaken = point !== undefined && this.drawing.press(point);
    this.refresh();
    return isTaken;
  }

  drag(pointer: Pointer): void {
    const point = this.plane.at(pointer.px);
    if (point) this.drawing.drag(point);
    this.refresh();
  }

  release(): void {
    this.drawing.release(this.plane.tremor);
    this.refresh();
  }

  // A press that is taken began a drawing anew, but that of a picture's box, which only moved.
  abandon(): void {
    this.drawing.release(this.plane.tremor);
    if (this.currentMode !== 'svg') this.cancel();
  }

  tap(pointer: Pointer): void {
    if (this.isChoosing) {
      this.pieceMark = this.viewer.surface?.pick(pointer.ray)?.material;
      this.isChoosing = !this.pieceMark;
      this.refresh();
      return;
    }
    const point = this.plane.at(pointer.px);
    if (point) this.drawing.tap(point);
    this.refresh();
  }

  /** Gives up what is going on: the choice of a piece, or the drawing; false if there is neither. */
  escape(): boolean {
    if (!this.isChoosing && !this.isStarted) return false;
    if (this.isChoosing) this.isChoosing = false;
    else this.cancel();
    this.refresh();
    return true;
  }

  /** Takes the last point back; false if nothing is drawn. */
  removeLast(): boolean {
    if (!this.isStarted) return false;
    this.drawing.removeLast();
    this.refresh();
    return true;
  }

  /** A step up or down of the chosen point's weight; false if none has one. */
  stepWeight(direction: 1 | -1): boolean {
    if (!this.weighted) return false;
    this.setWeight(this.weighted.weight * kWeightStep ** direction);
    return true;
  }

  cancel(): void {
    this.drawing = newDrawing(this.currentMode);
    this.chosenHandle = -1;
    this.refresh();
  }

  async cut(): Promise<void> {
    if (!this.isReady) return;
    const { drawing } = this;
    if (this.target === 'piece' && this.hasPiece && this.piece === undefined) {
      this.viewer.notify('error', 'Nothing was cut: the chosen piece is gone there; choose another');
      return;
    }
    this.underWay.add(drawing);
    this.refresh();
    const { widthM } = this;
    const request = this.request();
    const result = await this.viewer.attempt(
      () => call(CutService.method.createCut, request),
      'Nothing was cut: ',
    );
    this.underWay.delete(drawing);
    if (result) {
      const kind = result.status === CutResult_Status.APPLIED ? 'success' : 'info';
      this.viewer.notify(kind, cutText(result, widthM > 0), cutDetails(result));
      if (result.warnings.length > 0) this.viewer.notify('warning', warningText(result));
      if (drawing === this.drawing) {
        const { mode, target } = this;
        this.last = { drawing, mode, target, sizePx: this.viewer.stage.sizePx.clone() };
        this.cancel();
      }
    }
    this.refresh();
  }

  update(): void {
    this.followSize();
    if (this.isReady) this.forecast.follow(this.circumstances);
    this.showMarker();
    if (this.plane === this.material) this.showOnSheet();
    else this.showOnPicture();
    const { plane, drawing } = this;
    this.handles.show(
      drawing.handles.map((point, i) => ({
        px: plane.toPx(point),
        text: drawing.handleText(i),
        isChosen: drawing.weights !== undefined && i === this.chosenHandle,
      })),
    );
  }

  private get plane(): DrawingPlane {
    return this.target === 'material' ? this.material : this.picture;
  }

  private request() {
    return { parent: this.viewer.sheetName, cut: this.requested() };
  }

  private requested(): MessageInitShape<typeof CutSchema> {
    return { ...this.drawing.cut(), dash: this.dashLengths, widthM: this.widthM, view: this.view };
  }

  private get view(): ReturnType<typeof cutView> | undefined {
    const { stage } = this.viewer;
    const { target } = this;
    return target === 'material' ? undefined : cutView(stage.camera, stage.sizePx, target, this.depth, this.piece);
  }

  // Names what a cut goes through beside the drawing: the triangles, and on the picture what is seen there.
  private get circumstances(): string {
    return `${this.viewer.surface?.mirror.topologyVersion} ${JSON.stringify(this.view)}`;
  }

  // Label of the chosen piece; undefined if none is, or it has no material at its mark any more.
  private get piece(): number | undefined {
    const { surface } = this.viewer;
    const place = this.pieceMark && surface?.locator.find(this.pieceMark);
    return place && surface!.mirror.pieces[place.slot];
  }

  private showMarker(): void {
    const { surface, stage } = this.viewer;
    const mark = this.target === 'piece' && this.piece !== undefined ? this.pieceMark : undefined;
    const world = mark && surface?.toWorld(mark);
    const px = world && stage.project(world);
    this.marker.hidden = !px;
    if (px) this.marker.style.transform = `translate(${px.x.toFixed(1)}px, ${px.y.toFixed(1)}px)`;
  }

  // Metres of material.
  private get dashLengths(): number[] {
    const { isOn, cutM, leftM } = this.dashes;
    return isOn ? [cutM, leftM] : [];
  }

  // On a sheet that is seen face-on in the middle of the view.
  private get metresPerPx(): number {
    const { stage } = this.viewer;
    return stage.metresPerPx(stage.controls.target);
  }

  private showOnSheet(): void {
    const { surface } = this.viewer;
    if (!surface) return this.sheetPreview.hide();
    const { dashLengths, widthM } = this;
    this.preview.show([]);
    this.sheetPreview.show(surface, () => ({ lines: this.drawing.lines(), dashLengths, widthM }));
  }

  // Lengths are those in the middle of the view.
  private showOnPicture(): void {
    this.sheetPreview.hide();
    const lines = this.drawing.lines();
    const dashPx = this.dashLengths.map((metres) => metres / this.metresPerPx);
    const curves = lines.filter((line) => !line.isGuide).map((line) => line.points);
    const strip = stripAlong(curves, this.widthM / this.metresPerPx, dashPx);
    const toPx = (point: Point2) => this.picture.toPx(point);
    this.preview.show(
      lines.map(({ points, isGuide }) => ({ points: points.map(toPx), isGuide })),
      dashPx,
      strip.map((polygon) => polygon.map(toPx)),
    );
  }

  // A picture of another size shows the same things at the same distances from its middle, in parts of its height.
  private followSize(): void {
    const { x, y } = this.drawnSizePx;
    const { sizePx } = this.viewer.stage;
    if (this.plane === this.picture && y > 0 && !this.drawnSizePx.equals(sizePx)) {
      const scale = sizePx.y / y;
      this.drawing.map((at) => ({
        x: 0.5 * sizePx.x + scale * (at.x - 0.5 * x),
        y: 0.5 * sizePx.y + scale * (at.y - 0.5 * y),
      }));
    }
    this.drawnSizePx.copy(sizePx);
  }

  private chooseHandle(index: number): void {
    this.chosenHandle = index;
    this.refresh();
  }

  private moveHandle(index: number, px: Vector2): void {
    const point = this.plane.at(px);
    if (point && index < this.drawing.handles.length) this.drawing.moveHandle(index, point);
    this.refresh();
  }

  private refresh(): void {
    this.sheetPreview.changed();
    this.forecast.ask(this.isReady ? () => this.request() : undefined);
    this.viewer.stage.invalidate();
    this.changed();
  }
}
