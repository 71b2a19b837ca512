import { call } from '../api';
import { CutService } from '../gen/kerf/v1/cuts_pb';

/** The stable ids of a sheet's pieces, by their labels in frames of one topology version. */
export interface PieceList {
  topologyVersion: number;
  /** label -> id */
  ids: ReadonlyMap<number, number>;
}

const kPageSize = 1000;
const kRetryMs = 1000;

/** All pages of ListPieces; undefined where a cut came between two of them. */
async function listPieces(parent: string): Promise<PieceList | undefined> {
  const ids = new Map<number, number>();
  let topologyVersion: number | undefined;
  let pageToken = '';
  do {
    const page = await call(CutService.method.listPieces, { parent, pageSize: kPageSize, pageToken });
    if (topologyVersion !== undefined && page.topologyVersion !== topologyVersion) return undefined;
    topologyVersion = page.topologyVersion;
    for (const piece of page.pieces) ids.set(piece.label, Number(piece.id));
    pageToken = page.nextPageToken;
  } while (pageToken !== '');
  return { topologyVersion, ids };
}

/**
 * Frames number a sheet's pieces again after each cut; this asks the server which of them is which, one call at a time,
 * once for each topology version that is needed.
 */
export class PieceIds {
  private list: PieceList | undefined;
  private isAsking = false;
  private wanted: { sheet: string; version: number } | undefined;

  /** @param arrived  called when ids() has something new */
  constructor(
    private readonly arrived: () => void,
    private readonly ask: (sheet: string) => Promise<PieceList | undefined> = listPieces,
  ) {}

  /** label -> id at this version, if known; undefined asks for it. */
  at(sheet: string, version: number): ReadonlyMap<number, number> | undefined {
    if (this.wanted?.sheet !== sheet) this.list = undefined;
    this.wanted = { sheet, version };
    if (this.list?.topologyVersion === version) return this.list.ids;
    // A newer one waits for its frame.
    if (!this.isAsking && !(this.list && this.list.topologyVersion > version)) void this.fetch();
    return undefined;
  }

  /** Another connection: its versions need not be those of the one before. */
  reset(): void {
    this.list = undefined;
    this.wanted = undefined;
  }

  private async fetch(): Promise<void> {
    this.isAsking = true;
    const { wanted } = this;
    const list = await this.ask(wanted!.sheet).catch(() => undefined);
    // A failed call is made again, but not at once; a lost connection is reported elsewhere.
    if (!list) await new Promise((resolve) => setTimeout(resolve, kRetryMs));
    this.isAsking = false;
    if (list && this.wanted?.sheet === wanted!.sheet) this.list = list;
    if (this.wanted) this.arrived();
  }
}
