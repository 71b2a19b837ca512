import { call } from '../api';
import { CutService } from '../gen/kerf/v1/cuts_pb';
import type { Piece } from '../gen/kerf/v1/cuts_pb';
import { pieceColor } from '../scene/piece_colors';
import type { OpenSheet } from '../sheet/open_sheet';
import { areaText, massText } from '../tools/cut_text';
import { element, make, setText } from './dom';
import { FollowedList, whenPointedAt } from './followed_list';
import type { ListedSheet } from './followed_list';
import { KeptRows } from './kept_rows';
import type { KeptRow } from './kept_rows';
import type { Panel } from './side_panels';

// Number of pieces listed: the largest ones.
const kMaxShown = 200;
const kPageSize = 1000;

/** The sheet that is shown, for a list of its pieces. */
export interface ShownPieces extends ListedSheet {
  /** Highlights the piece with this label in the frames; undefined: no piece. */
  highlight(label: number | undefined): void;
  /** Moves the view so that the piece is in the middle. */
  centre(label: number): void;
}

interface Listed {
  readonly sheet: string;
  readonly surface: object | undefined;
  readonly version: number;
}

interface Row extends KeptRow {
  readonly size: HTMLElement;
  readonly origin: HTMLElement;
  /** Label of the piece in the frames; it may change with each cut. */
  label: number;
}

/**
 * Lists the pieces of the sheet with their sizes while the panel is open. It asks the server after each change of
 * topology.
 */
export class PiecePanel implements Panel {
  private readonly rows = new KeptRows(element('piece-list'), (id: bigint) => this.create(id));
  private readonly list: FollowedList<Listed>;
  // Id of the highlighted piece.
  private litId: bigint | undefined;

  constructor(
    live: Pick<OpenSheet, 'sheetName'>,
    private readonly shown: ShownPieces,
    private readonly send: typeof call = call,
  ) {
    const now = (): Listed | undefined => {
      const { surface, topologyVersion: version } = shown;
      return version === undefined ? undefined : { sheet: live.sheetName, surface, version };
    };
    this.list = new FollowedList(element('piece-error'), now, async (of) => {
      const version = await this.fetch(of.sheet);
      return version === undefined ? undefined : { ...of, version };
    });
  }

  opened(): void {
    this.list.open();
  }

  closed(): void {
    this.list.close();
    this.light(undefined);
  }

  /** Updates the list. It is called with each frame, and cheap if nothing has changed. */
  update(): void {
    this.list.update();
  }

  // Lists the pieces. Returns their topology version; undefined if a cut came between two pages.
  private async fetch(parent: string): Promise<number | undefined> {
    const pieces: Piece[] = [];
    let version: number | undefined;
    let pageToken = '';
    do {
      const page = await this.send(CutService.method.listPieces, { parent, pageSize: kPageSize, pageToken });
      if (version !== undefined && page.topologyVersion !== version) return undefined;
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
    const rows = this.rows.show(largest.map(({ id }) => id));
    largest.forEach((piece, i) => {
      const { size, origin } = rows[i];
      setText(size, `${areaText(piece.areaM2)}, ${massText(piece.massKg)}`);
      setText(origin, piece.parent === 0n ? 'there from the start' : `of piece ${piece.parent}`);
      rows[i].label = piece.label;
    });
    this.light(this.litId);
  }

  private light(id: bigint | undefined): void {
    const row = id === undefined ? undefined : this.rows.get(id);
    this.litId = row && id;
    this.shown.highlight(row?.label);
  }

  private create(id: bigint): Row {
    const swatch = make('i', { 'aria-hidden': 'true' });
    swatch.style.background = `#${pieceColor(Number(id)).getHexString()}`;
    const [size, origin] = [make('span', {}), make('small', {})];
    const name = make('b', {}, `Piece ${id}`);
    const button = make('button', { type: 'button', title: 'Show it in the middle' }, swatch, name, size, origin);
    const row: Row = { item: make('li', {}, button), size, origin, label: -1 };
    whenPointedAt(button, (isPointedAt) => this.light(isPointedAt ? id : undefined));
    button.addEventListener('click', () => this.shown.centre(row.label));
    return row;
  }
}
