import type { App } from '../app';
import type { SheetView } from '../scene/sheet_view';
import { PieceIds } from '../stream/piece_ids';
import { element } from './dom';
import { StrainScale } from './strain_scale';

/** How the sheet is drawn: wireframe, a colour for each piece, or colours by strain. */
export class SheetLook {
  isByPiece = false;
  isByStrain = false;
  readonly strainScale = new StrainScale();

  private readonly pieceIds: PieceIds;
  // Of a recording, by topology version.
  private numbered: { version: number; ids: ReadonlyMap<number, number> } | undefined;

  constructor(
    private readonly app: App,
    private readonly view: SheetView,
  ) {
    this.pieceIds = new PieceIds(() => app.showAgain());
  }

  get isWireframe(): boolean {
    return this.view.isWireframe;
  }

  toggleWireframe(): void {
    this.view.setWireframe(!this.isWireframe);
    element('wireframe').setAttribute('aria-pressed', String(this.isWireframe));
    this.app.stage.invalidate();
  }

  toggleByPiece(): void {
    this.isByPiece = !this.isByPiece;
    element('by-piece').setAttribute('aria-pressed', String(this.isByPiece));
    if (this.isByPiece && this.isByStrain) this.toggleByStrain();
    this.app.showAgain();
  }

  /** The server computes strains for whoever asks alone: another stream, which goes on from what is here. */
  toggleByStrain(): void {
    this.isByStrain = !this.isByStrain;
    element('by-strain').setAttribute('aria-pressed', String(this.isByStrain));
    this.strainScale.setShown(this.isByStrain);
    if (this.isByPiece && this.isByStrain) this.toggleByPiece();
    this.app.restartWatch(true);
    this.app.showAgain();
    if (this.isByStrain && this.lacksStrains) {
      this.app.notify('info', 'No strains were recorded here: colours by strain were not on at that time');
    }
  }

  /** Stable id of a piece by its label in the mirror's frames; undefined while it is not known. */
  pieceId(label: number): number | undefined {
    return this.idsOfPieces()?.get(label);
  }

  /** What is known of pieces is not of the sheet that comes. */
  reset(): void {
    this.pieceIds.reset();
    this.numbered = undefined;
  }

  /** Colours the sheet's newest state, which the view has. */
  color(): void {
    if (!this.isByStrain) {
      this.view.colorByPiece(this.isByPiece ? this.idsOfPieces() : null);
      return;
    }
    if (this.lacksStrains) {
      this.view.colorByPiece(null);
      this.strainScale.showMissing();
      return;
    }
    const end = this.view.colorByStrain();
    // The server has a scale of its own for its pictures, which come with it.
    if (end !== undefined && !this.app.imageMode.isShown) this.strainScale.show(end);
  }

  // What is shown is of a recording, and was recorded without strains. Live they are on their way.
  private get lacksStrains(): boolean {
    const { surface, watch } = this.app;
    return surface !== undefined && !watch && !surface.mirror.strains;
  }

  // Recordings have no ids, which count from 1: there, each number of a piece, which count from 0, makes one.
  private idsOfPieces(): ReadonlyMap<number, number> | undefined {
    const { surface, watch, sheetName } = this.app;
    if (!surface) return undefined;
    const { topologyVersion, numPieces } = surface.mirror;
    if (watch) return this.pieceIds.at(sheetName, topologyVersion);
    if (this.numbered?.version !== topologyVersion) {
      const ids = new Map(Array.from({ length: numPieces }, (_, label) => [label, label + 1]));
      this.numbered = { version: topologyVersion, ids };
    }
    return this.numbered.ids;
  }
}
