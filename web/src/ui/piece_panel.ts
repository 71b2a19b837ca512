import { call } from '../api';
import { CutService } from '../gen/kerf/v1/cuts_pb';
import type { Piece } from '../gen/kerf/v1/cuts_pb';
import { pieceColor } from '../scene/piece_colors';
import { areaText, massText } from '../tools/cut_text';
import { element, make, setText } from './dom';
import type { Panel } from './side_panels';

// Of more pieces the largest.
const kMaxShown = 200;
const kPageSize = 1000;

export interface PieceViewer {
  readonly sheetName: string;
  /** Of what is shown; undefined before the first frame. */
  readonly topologyVersion: number | undefined;
  /** Lights one piece up, by its label in the frames; undefined: none. */
  highlight(label: number | undefined): void;
  /** Moves the view so that the piece is in the middle. */
  centre(label: number): void;
}

/** All pieces of the sheet with their sizes, while the panel is open; asked for anew after each change of topology. */
export class PiecePanel implements Panel {
  private readonly list = element('piece-list');
  private isOpen = false;
  private isAsking = false;
  private shown: { sheet: string; version: number } | undefined;

  constructor(private readonly viewer: PieceViewer) {}

  opened(): void {
    this.isOpen = true;
    this.update();
  }

  closed(): void {
    this.isOpen = false;
    this.viewer.highlight(undefined);
  }

  /** Cheap where nothing changed: called with each frame. */
  update(): void {
    const { sheetName: sheet, topologyVersion: version } = this.viewer;
    if (!this.isOpen || this.isAsking || version === undefined) return;
    if (this.shown?.sheet === sheet && this.shown.version === version) return;
    this.isAsking = true;
    void this.fetch(sheet)
      .then((told) => (this.shown = told === undefined ? undefined : { sheet, version: told }))
      .finally(() => (this.isAsking = false));
  }

  // Topology version that is shown now; undefined where the call failed, or a cut came between two pages.
  private async fetch(parent: string): Promise<number | undefined> {
    const pieces: Piece[] = [];
    let version: number | undefined;
    let pageToken = '';
    do {
      const page = await call(CutService.method.listPieces, { parent, pageSize: kPageSize, pageToken }).catch(() => undefined);
      if (!page || (version !== undefined && page.topologyVersion !== version)) return undefined;
      version = page.topologyVersion;
      pieces.push(...page.pieces);
      pageToken = page.nextPageToken;
    } while (pageToken !== '');
    this.show(pieces);
    return version;
  }

  private show(pieces: readonly Piece[]): void {
    const largest = [...pieces].sort((a, b) => b.areaM2 - a.areaM2).slice(0, kMaxShown);
    const rest = pieces.length - largest.length;
    setText(element('piece-rest'), rest > 0 ? `and ${rest.toLocaleString('en')} smaller ones` : '');
    this.viewer.highlight(undefined);
    this.list.replaceChildren(...largest.map((piece) => make('li', {}, this.row(piece))));
  }

  private row(piece: Piece): HTMLButtonElement {
    const swatch = make('i', { 'aria-hidden': 'true' });
    swatch.style.background = `#${pieceColor(Number(piece.id)).getHexString()}`;
    const origin = piece.parent === 0n ? 'there from the start' : `of piece ${piece.parent}`;
    const row = make(
      'button',
      { type: 'button', title: 'Show it in the middle' },
      swatch,
      make('b', {}, `Piece ${piece.id}`),
      make('span', {}, `${areaText(piece.areaM2)}, ${massText(piece.massKg)}`),
      make('small', {}, origin),
    );
    for (const name of ['pointerenter', 'focus']) row.addEventListener(name, () => this.viewer.highlight(piece.label));
    for (const name of ['pointerleave', 'blur']) row.addEventListener(name, () => this.viewer.highlight(undefined));
    row.addEventListener('click', () => this.viewer.centre(piece.label));
    return row;
  }
}
