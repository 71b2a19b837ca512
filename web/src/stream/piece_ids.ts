import { call } from '../api';
import { CutService } from '../gen/kerf/v1/cuts_pb';

/** The stable ids of a sheet's pieces, by the labels that frames of one topology version use. */
export interface PieceList {
  topologyVersion: number;
  /** label -> id */
  ids: ReadonlyMap<number, number>;
}

const kPageSize = 1000;
const kRetryMs = 1000;

/** Fetches all pages of ListPieces; undefined if a cut came between two pages. */
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
 * Finds the ids of pieces, because frames number the pieces again after each cut. Asks the server in one call at a
 * time, once for each topology version that is needed.
 */
export class PieceIds {
  private list: PieceList | undefined;
  private isAsking = false;
  private numResets = 0;
  private wanted: { sheet: string; version: number } | undefined;

  /** @param arrived  called when at() may have a new answer */
  constructor(
    private readonly arrived: () => void,
    private readonly ask: (sheet: string) => Promise<PieceList | undefined> = listPieces,
  ) {}

  /** Returns label -> id at this version; if it is not known, returns undefined and asks the server. */
  at(sheet: string, version: number): ReadonlyMap<number, number> | undefined {
    if (this.wanted?.sheet !== sheet) this.list = undefined;
    this.wanted = { sheet, version };
    if (this.list?.topologyVersion === version) return this.list.ids;
    // A newer list is kept until its frame arrives.
    if (!this.isAsking && !(this.list && this.list.topologyVersion > version)) void this.fetch();
    return undefined;
  }

  /** Forgets all ids. Call it when topology versions begin again. */
  reset(): void {
    this.numResets += 1;
    this.list = undefined;
    this.wanted = undefined;
  }

  private async fetch(): Promise<void> {
    this.isAsking = true;
    const { wanted } = this;
    const { numResets } = this;
    const list = await this.ask(wanted!.sheet).catch(() => undefined);
    // Waits before a failed call is repeated; a lost connection is reported elsewhere.
    if (!list) await new Promise((resolve) => setTimeout(resolve, kRetryMs));
    this.isAsking = false;
    if (list && this.wanted?.sheet === wanted!.sheet && numResets === this.numResets) this.list = list;
    if (this.wanted) this.arrived();
  }
}
