import { call } from '../../api';
import { CutService, ScheduledCuts_State } from '../../gen/kerf/v1/cuts_pb';
import type { ListCutsResponse_Entry, ScheduledCuts } from '../../gen/kerf/v1/cuts_pb';
import { lipsAlong } from '../../geometry/lips';
import type { LipFinder, LipRecord } from '../../geometry/lips';
import type { OpenSheet } from '../../sheet/open_sheet';
import { areaText, countText } from '../../tools/cut_text';
import { confirmed } from '../confirmation';
import { element, icon, make, setText } from '../dom';
import { FollowedList, whenPointedAt } from '../followed_list';
import type { ListedSheet } from '../followed_list';
import { KeptRows } from '../kept_rows';
import type { KeptRow } from '../kept_rows';
import type { Panel } from '../side_panels';
import { CutMakers } from './cut_makers';
import type { Act } from './cut_makers';
import { cutNumber, cutWords } from './cut_words';

// Number of cuts listed: the newest ones.
const kMaxShown = 200;
const kPageSize = 1000;

/** The sheet that is shown, for a list of its cuts. */
export interface ShownCuts extends ListedSheet {
  readonly lips: Pick<LipRecord, 'at'>;
  highlightLips(find: LipFinder | undefined): void;
  /** Moves the view so that the lips are in the middle. */
  centreLips(find: LipFinder): void;
}

interface Row extends KeptRow {
  readonly button: HTMLElement;
  readonly undo: HTMLElement;
  readonly pieces: HTMLElement;
  readonly facts: HTMLElement;
  entry: ListCutsResponse_Entry | undefined;
  /** Number of cuts that are listed after this one. */
  numNewer: number;
}

interface Listed {
  readonly sheet: string;
  readonly surface: object | undefined;
  readonly version: number;
  readonly numActs: number;
}

/** Returns facts about a cut in a line: "Circle · tick 300 · by alice". */
export function cutFacts({ cut, result }: ListCutsResponse_Entry, maker: string | undefined): string {
  const removed = result?.removed ? [`${areaText(result.removed.areaM2)} removed`] : [];
  const tick = result ? [`tick ${Number(result.tick).toLocaleString('en')}`] : [];
  return [cut ? cutWords(cut) : 'Drawing', ...removed, ...tick, ...(maker ? [`by ${maker}`] : [])].join(' · ');
}

/** Says which cuts wait for their tick; empty if none does. */
export function waitingText(scheduled: readonly ScheduledCuts[]): string {
  return scheduled
    .filter(({ state }) => state === ScheduledCuts_State.WAITING)
    .map(({ tick, cuts }) => `${countText(cuts.length, 'cut')} at tick ${Number(tick).toLocaleString('en')}`)
    .join(', ');
}

/**
 * Lists the cuts of the sheet, the newest first, while the panel is open. A cut that is pointed at or chosen is shown on
 * the sheet. Each can be undone, with all that were made after it.
 */
export class CutList implements Panel {
  readonly makers = new CutMakers();

  private readonly rows = new KeptRows(element('cut-list'), (name: string) => this.create(name));
  private readonly list: FollowedList<Listed>;
  private chosen: string | undefined;
  private pointedAt: string | undefined;
  private numActs = 0;
  private sheet = '';

  constructor(
    live: Pick<OpenSheet, 'sheetName'>,
    private readonly shown: ShownCuts,
    private readonly history: { undoTo(cut: string, mostSteps: number): Promise<void> },
    private readonly send: typeof call = call,
  ) {
    const now = (): Listed | undefined => {
      const { surface, topologyVersion: version } = shown;
      return version === undefined ? undefined : { sheet: live.sheetName, surface, version, numActs: this.numActs };
    };
    this.list = new FollowedList(element('cut-error'), now, async (of) => {
      await this.fetch(of.sheet);
      return of;
    });
  }

  opened(): void {
    this.list.open();
  }

  closed(): void {
    this.list.close();
    this.chosen = this.pointedAt = undefined;
    this.light();
  }

  /** Takes a change that the stream reports. It may be of cuts that are planned, which do not change the mesh yet. */
  acted(activity: Act): void {
    this.makers.acted(activity);
    if (activity.call.includes('Cut')) this.numActs += 1;
  }

  /** Updates the list. It is called at each animation frame, and cheap if nothing has changed. */
  update(): void {
    this.list.update();
  }

  private async fetch(parent: string): Promise<void> {
    const entries: ListCutsResponse_Entry[] = [];
    if (this.sheet !== '' && this.sheet !== parent) this.makers.clear();
    this.sheet = parent;
    const people = this.makers.takeWaiting();
    let scheduled: ScheduledCuts[] = [];
    let pageToken = '';
    do {
      const page = await this.send(CutService.method.listCuts, { parent, pageSize: kPageSize, pageToken });
      if (pageToken === '') scheduled = page.scheduled;
      entries.push(...page.cuts);
      pageToken = page.nextPageToken;
    } while (pageToken !== '');
    const named = entries.filter(({ result }) => result?.name);
    this.makers.listed(named.map(({ result }) => result!.name), people);
    this.show(named);
    const waiting = waitingText(scheduled);
    setText(element('cut-waiting'), waiting === '' ? '' : `Planned: ${waiting}`);
  }

  private show(entries: readonly ListCutsResponse_Entry[]): void {
    const newest = entries.slice(-kMaxShown).reverse();
    const rest = entries.length - newest.length;
    setText(element('cut-rest'), rest > 0 ? `and ${rest.toLocaleString('en')} older ones` : '');
    element('cut-list-empty').hidden = entries.length > 0;
    const rows = this.rows.show(newest.map(({ result }) => result!.name));
    newest.forEach((entry, i) => {
      const row = rows[i];
      row.entry = entry;
      row.numNewer = i;
      setText(row.pieces, countText(entry.result!.pieces, 'piece'));
      setText(row.facts, cutFacts(entry, this.makers.of(entry.result!.name)));
      const after = i === 0 ? '' : ` and the ${i === 1 ? 'one' : i} after it`;
      const label = `Undo cut ${cutNumber(entry.result!.name)}${after}`;
      row.undo.title = label;
      row.undo.setAttribute('aria-label', label);
    });
    this.light();
  }

  // Shows the cut that is pointed at, or else the chosen one.
  private light(): void {
    if (this.chosen !== undefined && !this.rows.get(this.chosen)) this.chosen = undefined;
    const name = this.pointedAt ?? this.chosen;
    this.shown.highlightLips(name === undefined ? undefined : this.finder(name));
  }

  private finder(name: string): LipFinder | undefined {
    const { cut, result } = this.rows.get(name)?.entry ?? {};
    if (!cut || !result) return undefined;
    return lipsAlong(cut, result.deviationM) ?? this.shown.lips.at(result.topologyVersion);
  }

  private choose(name: string): void {
    const before = this.chosen;
    this.chosen = before === name ? undefined : name;
    for (const each of [before, name]) {
      const isChosen = each === this.chosen;
      if (each) this.rows.get(each)?.button.setAttribute('aria-pressed', String(isChosen));
    }
    this.light();
    if (this.chosen === undefined) return;
    const find = this.finder(name);
    const number = cutNumber(name);
    setText(element('cut-unseen'), find ? '' : `Cut ${number} was made on a picture before you came, so its lips are not known.`);
    if (find) this.shown.centreLips(find);
  }

  private async undo(name: string): Promise<void> {
    const { numNewer } = this.rows.get(name)!;
    const question = `Undo ${numNewer + 1} cuts, back to before cut ${cutNumber(name)}?`;
    if (numNewer > 0 && !(await confirmed(question, 'Undo them'))) return;
    await this.history.undoTo(name, numNewer + 1);
  }

  private create(name: string): Row {
    const [pieces, facts] = [make('span', {}), make('small', {})];
    const heading = make('b', {}, `Cut ${cutNumber(name)}`);
    const shape = { type: 'button', className: 'open', title: 'Show it on the sheet', 'aria-pressed': 'false' };
    const button = make('button', shape, heading, pieces, facts);
    const undo = make('button', { type: 'button', className: 'icon', 'data-needs': 'cut' }, icon('undo'));
    whenPointedAt(button, (isPointedAt) => this.point(isPointedAt ? name : undefined));
    button.addEventListener('click', () => this.choose(name));
    undo.addEventListener('click', () => void this.undo(name));
    return { item: make('li', {}, button, undo), button, undo, pieces, facts, entry: undefined, numNewer: 0 };
  }

  private point(name: string | undefined): void {
    this.pointedAt = name;
    this.light();
  }
}
