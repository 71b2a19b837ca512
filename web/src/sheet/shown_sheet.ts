import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import { LipRecord } from '../geometry/lips';
import type { LipFinder } from '../geometry/lips';
import { Surface } from '../geometry/surface';
import { lipCentre } from '../scene/lip_highlight';
import { pieceCentre } from '../scene/piece_highlight';
import { SheetScene } from '../scene/sheet_scene';
import type { SheetView } from '../scene/sheet_view';
import type { CameraPlace, Stage } from '../scene/stage';
import type { SheetCopy } from '../stream/sheet_copy';
import type { ShownState } from './open_sheet';

export interface ShownSheetEvents {
  /** Called when frames begin to come from another connection, recording or state of the sheet. */
  onSource(): void;
  /** Called when settings arrive. `before`: those before; undefined for the first settings of a sheet. */
  onSettings(sheet: Sheet, before: Sheet | undefined): void;
}

/** The sheet that is shown, live or from a recording: its newest frame, its settings and its scene. */
export class ShownSheet implements ShownState {
  surface: Surface | undefined;
  sheet: Sheet | undefined;
  /** Lips that appeared while the sheet was shown. */
  readonly lips = new LipRecord();

  private readonly scene: SheetScene;
  // True if the scene lacks the newest frame or the present look.
  private isStale = false;
  // True if a frame has come since the last drawing.
  private hasArrived = false;
  private isFitted = false;
  private firstPlace: CameraPlace | undefined;

  constructor(
    private readonly stage: Stage,
    private readonly events: ShownSheetEvents,
  ) {
    this.scene = new SheetScene(stage);
  }

  get view(): SheetView {
    return this.scene.view;
  }

  get topologyVersion(): number | undefined {
    return this.surface?.mirror.topologyVersion;
  }

  /** Takes a frame of the live stream or of a recording. */
  receive(copy: SheetCopy): void {
    if (this.surface?.mirror !== copy) {
      this.surface = new Surface(copy);
      this.events.onSource();
    }
    this.scene.object.visible = true;
    this.isStale = true;
    this.hasArrived = true;
    this.stage.invalidate();
  }

  set(sheet: Sheet): void {
    const before = this.sheet;
    this.sheet = sheet;
    this.events.onSettings(sheet, before);
    this.scene.set(sheet);
    this.showAgain();
  }

  /** Forgets the sheet, which stays in the picture until the next one comes. */
  clear(): void {
    this.surface = undefined;
    this.sheet = undefined;
    this.isStale = false;
    this.isFitted = false;
  }

  /** Takes the last sheet out of the picture. */
  hide(): void {
    this.scene.object.visible = false;
    this.stage.invalidate();
  }

  /** Looks at the first sheet that is shown from this place, and not so that all of it is in view. */
  beginAt(place: CameraPlace): void {
    this.firstPlace = place;
  }

  /** Moves the camera so that the whole sheet is in view. */
  fit(): void {
    if (this.surface) this.scene.fit(this.surface, this.sheet?.scene?.colliders ?? []);
  }

  /** Highlights the piece with this label in the frames; undefined: no piece. */
  highlight(label: number | undefined): void {
    this.view.highlight(label);
    this.showAgain();
  }

  /** Moves the view so that the piece is in the middle. */
  centre(label: number): void {
    if (this.surface) this.stage.lookAt(pieceCentre(this.surface.mirror, label));
  }

  /** Highlights the lips of a cut; undefined: none. */
  highlightLips(find: LipFinder | undefined): void {
    this.view.highlightLips(find);
    this.showAgain();
  }

  /** Moves the view so that the lips of a cut are in the middle; does nothing if they are gone. */
  centreLips(find: LipFinder): void {
    const centre = this.surface && lipCentre(find, this.surface);
    if (centre) this.stage.lookAt(centre);
  }

  /** Sets whether the page draws sheet and colliders; otherwise the server's picture shows them. */
  setDrawn(isDrawn: boolean): void {
    this.scene.setDrawn(isDrawn);
    this.showAgain();
  }

  /** Sets whether sheet and solids hide things that lie over the server's picture. */
  setHiding(isHiding: boolean): void {
    if (this.scene.setHiding(isHiding)) this.showAgain();
  }

  /** Draws the newest frame once more, because its look may have changed. */
  showAgain(): void {
    this.isStale = this.surface !== undefined;
    this.stage.invalidate();
  }

  /** Brings the newest frame into the scene; false if it is there already. */
  update(): boolean {
    if (!this.surface || !this.isStale) return false;
    this.isStale = false;
    if (!this.isFitted) {
      this.fit();
      // Fits again when the settings, and with them the colliders, are known.
      this.isFitted = this.sheet !== undefined;
      if (this.firstPlace) this.stage.place = this.firstPlace;
      if (this.isFitted) this.firstPlace = undefined;
    }
    this.lips.see(this.surface);
    this.scene.update(this.surface);
    return true;
  }

  /** Notes that a picture was drawn; true if a frame has come since the picture before. */
  drawn(): boolean {
    const { hasArrived } = this;
    this.hasArrived = false;
    return hasArrived;
  }
}
