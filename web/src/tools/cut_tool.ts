import type { MessageInitShape } from '@bufbuild/protobuf';
import { Vector2 } from 'three';
import { call } from '../api';
import { CutResult_Status, CutService } from '../gen/kerf/v1/cuts_pb';
import type { CutSchema } from '../gen/kerf/v1/scene_pb';
import type { OpenSheet } from '../sheet/open_sheet';
import { ChosenPiece } from './chosen_piece';
import { CutDisplay } from './cut_display';
import { CutForecast } from './cut_forecast';
import { cutDetails, cutText, warningText } from './cut_text';
import { MaterialPlane, PicturePlane, cutView, frontHalf } from './drawing_plane';
import type { CutTarget, DepthRange, DrawingPlane } from './drawing_plane';
import type { Drawing } from './drawings/drawing';
import { newDrawing } from './drawings/kinds';
import type { CutMode } from './drawings/kinds';
import { PictureDrawing } from './drawings/picture_drawing';
import type { Picture } from './drawings/picture_drawing';
import { pressVerb } from './press_verb';
import type { Pointer, Tool, Viewer } from './tool';

type CutViewer = Pick<Viewer, 'overlay' | 'stage' | 'shown' | 'notices'> & { live: Pick<OpenSheet, 'sheetName'> };

/** A perforation: lengths of the sheet cut and left in turn, metres. */
export interface Dashes {
  isOn: boolean;
  cutM: number;
  leftM: number;
}

/** Weights are in kLeastWeight..1 / kLeastWeight. */
export const kLeastWeight = 0.05;
// A key changes a weight by this factor.
const kWeightStep = 1.25;

/**
 * Lets the user draw a curve and cuts along it: through the sheet seen under the curve on the picture or, on request,
 * through the material. A drawing on the material moves with the sheet. A cut from border to border must start and end
 * beside the sheet.
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
  private readonly underWay = new Set<Drawing>(); // drawings being cut; another may be drawn and cut at the same time
  private readonly chosenPiece: ChosenPiece;
  private last: { drawing: Drawing; mode: CutMode; target: CutTarget; sizePx: Vector2 } | undefined;
  private readonly picture = new PicturePlane();
  private readonly material: MaterialPlane;
  private readonly display: CutDisplay;
  private readonly forecast: CutForecast;
  private readonly drawnSizePx = new Vector2();

  /**
   * @param changed  called when the prompt or the possible actions may have changed
   * @param made     called with the name of a cut that was made
   */
  constructor(
    private readonly viewer: CutViewer,
    private readonly changed: () => void,
    private readonly made: (cut: string) => void = () => {},
  ) {
    this.material = new MaterialPlane(viewer);
    this.chosenPiece = new ChosenPiece(viewer);
    this.display = new CutDisplay(viewer, {
      onChosen: (index) => this.chooseHandle(index),
      onMoved: (index, px) => this.moveHandle(index, px),
      onTapped: (px) => this.tap({ px, ray: viewer.stage.rayAt(px) }),
    });
    this.forecast = new CutForecast(changed);
  }

  get mode(): CutMode {
    return this.currentMode;
  }

  setMode(mode: CutMode): void {
    this.currentMode = mode;
    this.cancel();
  }

  /** The drawing from a file that lies on the sheet; undefined if there is none. */
  get laid(): PictureDrawing | undefined {
    return this.drawing instanceof PictureDrawing && this.drawing.isStarted ? this.drawing : undefined;
  }

  redraw(): void {
    this.refresh();
  }

  /** Lays a drawing from a file on the sheet; false if there is no sheet yet. */
  lay(picture: Picture): boolean {
    const { locator } = this.viewer.shown.surface ?? {};
    if (!locator) return false;
    this.setMode('svg');
    this.drawing = new PictureDrawing(picture, locator);
    this.refresh();
    return true;
  }

  /** The chosen target; a drawing from a file always lies on the material. */
  get target(): CutTarget {
    return this.currentMode === 'svg' ? 'material' : this.currentTarget;
  }

  /**
   * True if a piece was chosen by a tap. Without a choice, the piece seen where the line first meets the sheet is cut.
   */
  get hasPiece(): boolean {
    return this.chosenPiece.isChosen;
  }

  /** Lets the next tap choose the piece to cut; if one is chosen, forgets it instead. */
  choosePiece(): void {
    this.chosenPiece.toggle();
    this.refresh();
  }

  get hasLast(): boolean {
    return this.last !== undefined && !this.isStarted;
  }

  /** Shows the drawing that was cut last again, in its old place on the picture or on the material. */
  again(): void {
    if (!this.hasLast) return;
    const { drawing, mode, target, sizePx } = this.last!;
    this.currentMode = mode;
    this.currentTarget = target;
    this.drawing = drawing;
    this.drawnSizePx.copy(sizePx);
    this.refresh();
  }

  /** Chooses a target. A drawing that was begun keeps its place in the picture on the new plane. */
  setTarget(target: CutTarget): void {
    const from = this.plane;
    this.currentTarget = target;
    this.chosenPiece.isChoosing = false;
    const { surface } = this.viewer.shown;
    if (target === 'depth' && surface) Object.assign(this.depth, frontHalf(surface, this.viewer.stage.camera));
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

  /** True while a drawing lies on the moving sheet. */
  get isOnSheet(): boolean {
    return this.isStarted && this.target === 'material';
  }

  get prompt(): string {
    return this.chosenPiece.isChoosing ? `${pressVerb()} the piece to cut` : this.drawing.prompt;
  }

  /** Warning that the sheet would be too slow for real time after the cut; else empty. */
  get warning(): string {
    return this.forecast.warning;
  }

  /** The chosen point and its weight; undefined if it has none. */
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

  /** Width of the strip that the cut removes, metres of the sheet; 0: none. */
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
    this.chosenPiece.forget();
    this.cancel();
    // Removes the drawing from the canvas now, because later only the chosen tool is updated.
    this.update();
  }

  press(pointer: Pointer): boolean {
    if (this.chosenPiece.isChoosing) return false;
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

  // A press that was taken has begun a new drawing, unless it only moved the box of an SVG drawing.
  abandon(): void {
    this.drawing.release(this.plane.tremor);
    if (this.currentMode !== 'svg') this.cancel();
  }

  tap(pointer: Pointer): void {
    if (this.chosenPiece.isChoosing) {
      this.chosenPiece.take(pointer.ray);
      this.refresh();
      return;
    }
    const point = this.plane.at(pointer.px);
    if (point) this.drawing.tap(point);
    this.refresh();
  }

  /** Cancels the choice of a piece, or else the drawing; false if there is neither. */
  escape(): boolean {
    const { chosenPiece } = this;
    if (!chosenPiece.isChoosing && !this.isStarted) return false;
    if (chosenPiece.isChoosing) chosenPiece.isChoosing = false;
    else this.cancel();
    this.refresh();
    return true;
  }

  /** Removes the last point; false if nothing is drawn. */
  removeLast(): boolean {
    if (!this.isStarted) return false;
    this.drawing.removeLast();
    this.refresh();
    return true;
  }

  /** Changes the chosen point's weight by a step up or down; false if no point with a weight is chosen. */
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
    const { notices } = this.viewer;
    if (this.target === 'piece' && this.hasPiece && this.chosenPiece.label === undefined) {
      notices.notify('error', 'Nothing was cut: the chosen piece is gone there; choose another');
      return;
    }
    this.underWay.add(drawing);
    this.refresh();
    const { widthM } = this;
    const request = this.request();
    const result = await notices.attempt(() => call(CutService.method.createCut, request), 'Nothing was cut: ');
    this.underWay.delete(drawing);
    if (result) {
      if (result.name !== '') this.made(result.name);
      const kind = result.status === CutResult_Status.APPLIED ? 'success' : 'info';
      notices.notify(kind, cutText(result, widthM > 0), cutDetails(result));
      if (result.warnings.length > 0) notices.notify('warning', warningText(result));
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
    this.display.show({
      drawing: this.drawing,
      plane: this.plane,
      isOnMaterial: this.plane === this.material,
      dashLengths: this.dashLengths,
      widthM: this.widthM,
      chosenHandle: this.chosenHandle,
      mark: this.target === 'piece' ? this.chosenPiece.place : undefined,
    });
  }

  private get plane(): DrawingPlane {
    return this.target === 'material' ? this.material : this.picture;
  }

  private request() {
    return { parent: this.viewer.live.sheetName, cut: this.requested() };
  }

  private requested(): MessageInitShape<typeof CutSchema> {
    return { ...this.drawing.cut(), dash: this.dashLengths, widthM: this.widthM, view: this.view };
  }

  private get view(): ReturnType<typeof cutView> | undefined {
    const { stage } = this.viewer;
    const { target } = this;
    return target === 'material' ? undefined : cutView(stage.camera, stage.sizePx, target, this.depth, this.chosenPiece.label);
  }

  // Text that changes with all that affects a cut besides the drawing: the triangles and, on the picture, the view.
  private get circumstances(): string {
    const mirror = this.viewer.shown.surface?.mirror;
    return `${mirror?.epoch} ${mirror?.topologyVersion} ${JSON.stringify(this.view)}`;
  }

  // Lengths cut and left in turn, metres of material.
  private get dashLengths(): number[] {
    const { isOn, cutM, leftM } = this.dashes;
    return isOn ? [cutM, leftM] : [];
  }

  // Scales a drawing on the picture after a change of the canvas: things keep their distance from the middle as a share
  // of the height.
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
    this.display.changed();
    this.forecast.ask(this.isReady ? () => this.request() : undefined);
    this.viewer.stage.invalidate();
    this.changed();
  }
}
