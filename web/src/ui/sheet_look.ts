import type { Notifier } from '../notifier';
import type { SheetView } from '../scene/sheet_view';
import type { Stage } from '../scene/stage';
import type { OpenSheet, ShownState } from '../sheet/open_sheet';
import { PieceIds } from '../stream/piece_ids';
import { element } from './dom';
import { StrainScale } from './strain_scale';

/** The parts of the viewer that show the look. */
export interface LookedAt {
  readonly view: Pick<SheetView, 'isWireframe' | 'setWireframe' | 'colorByPiece' | 'colorByStrain'>;
  readonly shown: Pick<ShownState, 'surface'> & {
    /** Draws the sheet once more, in its new look. */
    showAgain(): void;
  };
  readonly live: Pick<OpenSheet, 'sheetName'> & {
    readonly isWatched: boolean;
    /** Starts another stream of the same sheet, which continues from the present triangles. */
    restart(goesOn: true): void;
  };
  readonly stage: Pick<Stage, 'invalidate'>;
  readonly notices: Notifier;
  /** True if a picture of the server is shown in place of the mesh. */
  isPictureShown(): boolean;
}

/** The look of the sheet: wireframe, a colour for each piece, or colours by strain. */
export class SheetLook {
  isByPiece = false;
  isByStrain = false;
  readonly strainScale = new StrainScale();

  private readonly pieceIds: PieceIds;
  // Ids made for a recording's pieces, in one topology version.
  private numbered: { version: number; ids: ReadonlyMap<number, number> } | undefined;

  constructor(private readonly parts: LookedAt) {
    this.pieceIds = new PieceIds(() => parts.shown.showAgain());
  }

  get isWireframe(): boolean {
    return this.parts.view.isWireframe;
  }

  toggleWireframe(): void {
    this.parts.view.setWireframe(!this.isWireframe);
    element('wireframe').setAttribute('aria-pressed', String(this.isWireframe));
    this.parts.stage.invalidate();
  }

  toggleByPiece(): void {
    this.isByPiece = !this.isByPiece;
    element('by-piece').setAttribute('aria-pressed', String(this.isByPiece));
    if (this.isByPiece && this.isByStrain) this.toggleByStrain();
    this.parts.shown.showAgain();
  }

  /** Shows or hides strains. It starts another stream, because the server sends strains only on request. */
  toggleByStrain(): void {
    this.isByStrain = !this.isByStrain;
    element('by-strain').setAttribute('aria-pressed', String(this.isByStrain));
    this.strainScale.setShown(this.isByStrain);
    if (this.isByPiece && this.isByStrain) this.toggleByPiece();
    this.parts.live.restart(true);
    this.parts.shown.showAgain();
    if (this.isByStrain && this.lacksStrains) {
      this.parts.notices.notify('info', 'No strains were recorded here: colouring by strain was off at that time');
    }
  }

  /** Returns the stable id of a piece by its label in the mirror's frames; undefined while it is not known. */
  pieceId(label: number): number | undefined {
    return this.idsOfPieces()?.get(label);
  }

  /** Forgets all ids of pieces. Call it before another sheet or connection. */
  reset(): void {
    this.pieceIds.reset();
    this.numbered = undefined;
  }

  /** Colours the newest state of the sheet, after the view has taken it. */
  color(): void {
    const { view } = this.parts;
    if (!this.isByStrain) {
      view.colorByPiece(this.isByPiece ? this.idsOfPieces() : null);
      return;
    }
    if (this.lacksStrains) {
      view.colorByPiece(null);
      this.strainScale.showMissing();
      return;
    }
    const end = view.colorByStrain();
    // The server's pictures have their own scale.
    if (end !== undefined && !this.parts.isPictureShown()) this.strainScale.show(end);
  }

  // True if a recording without strains is shown. Strains of a live sheet may still arrive.
  private get lacksStrains(): boolean {
    const { surface } = this.parts.shown;
    return surface !== undefined && !this.parts.live.isWatched && !surface.mirror.strains;
  }

  // Returns the ids of pieces. A recording has none, so its labels, counted from 0, become ids counted from 1.
  private idsOfPieces(): ReadonlyMap<number, number> | undefined {
    const { surface } = this.parts.shown;
    const { isWatched, sheetName } = this.parts.live;
    if (!surface) return undefined;
    const { topologyVersion, numPieces } = surface.mirror;
    if (isWatched) return this.pieceIds.at(sheetName, topologyVersion);
    if (this.numbered?.version !== topologyVersion) {
      const ids = new Map(Array.from({ length: numPieces }, (_, label) => [label, label + 1]));
      this.numbered = { version: topologyVersion, ids };
    }
    return this.numbered.ids;
  }
}
