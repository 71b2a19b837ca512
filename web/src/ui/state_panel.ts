import { call } from '../api';
import { SheetService } from '../gen/kerf/v1/sheets_pb';
import type { SavedState, Sheet } from '../gen/kerf/v1/sheets_pb';
import { NewestAnswer } from '../newest_answer';
import type { Reporter } from '../notifier';
import type { OpenSheet } from '../sheet/open_sheet';
import { countText } from '../tools/cut_text';
import { element, icon, make, setText } from './dom';
import { agreedForEveryone } from './for_everyone';
import { KeptRows } from './kept_rows';
import type { KeptRow } from './kept_rows';
import { Polling } from './polling';
import type { Panel } from './side_panels';

// Period of updates while the panel is open.
const kListPeriodMs = 2000;

/** The live sheet, for calls that change it. */
interface RestoredSheet extends Pick<OpenSheet, 'sheetName'> {
  /** Runs a call whose answer has the sheet's settings. */
  command(run: () => Promise<Sheet>): Promise<void>;
}

interface Row extends KeptRow {
  readonly facts: HTMLElement;
}

/** sheets/demo/states/before -> before */
function stateId(name: string): string {
  return name.slice(name.lastIndexOf('/') + 1);
}

/** Returns the first of state-1, state-2, ... that is not taken. */
export function freeStateId(taken: readonly string[]): string {
  let number = 1;
  while (taken.includes(`state-${number}`)) number += 1;
  return `state-${number}`;
}

/** Returns "tick 120, 2,500 vertices, 14:05:09". */
export function stateFacts({ tick, numVertices, savedUnixUs }: SavedState): string {
  const time = new Date(Number(savedUnixUs) / 1000).toLocaleTimeString('en-GB');
  return `tick ${Number(tick).toLocaleString('en')}, ${countText(numVertices, 'vertex', 'vertices')}, ${time}`;
}

/** Saves states of the sheet under names, lists them, goes back to one and deletes them. */
export class StatePanel implements Panel {
  private readonly rows = new KeptRows(element('state-list'), (name: string) => this.create(name));
  private readonly nameField = element<HTMLInputElement>('state-name');
  private names: string[] = [];
  // Keeps the list while the server cannot be reached, which the connection chip shows.
  private readonly answers = new NewestAnswer(
    () => this.send(SheetService.method.listStates, { parent: this.live.sheetName }),
    ({ states }) => this.show(states),
  );
  private readonly polling = new Polling(() => this.answers.fetch(), kListPeriodMs);

  /** @param numStreams  returns the number of streams of the sheet to this page */
  constructor(
    private readonly live: RestoredSheet,
    private readonly reporter: Reporter,
    private readonly numStreams: () => number,
    private readonly send: typeof call = call,
  ) {
    element('state-form').addEventListener('submit', (event) => {
      event.preventDefault();
      void this.save();
    });
  }

  opened(): void {
    this.polling.start();
  }

  closed(): void {
    this.polling.stop();
  }

  /** Saves under the name in the field, or under a free one. */
  async save(): Promise<void> {
    const { sheetName: parent } = this.live;
    const id = this.nameField.value.trim() || freeStateId(this.names.map(stateId));
    const saving = () => this.send(SheetService.method.saveState, { parent, stateId: id });
    const saved = await this.reporter.attempt(saving, 'Nothing was saved: ');
    if (!saved) return;
    this.nameField.value = '';
    this.reporter.notify('success', `Saved as ${id}, at tick ${Number(saved.tick).toLocaleString('en')}`);
    await this.answers.refresh();
  }

  /** Goes back to a state; asks for confirmation if others watch the sheet. */
  async restore(name: string): Promise<void> {
    const { live, reporter, send } = this;
    if (!(await agreedForEveryone(live.sheetName, this.numStreams(), 'Restore', reporter, send))) return;
    await live.command(() => send(SheetService.method.restoreState, { name }));
  }

  async remove(name: string): Promise<void> {
    const deletion = () => this.send(SheetService.method.deleteState, { name });
    if (!(await this.reporter.attempt(deletion, 'Nothing was deleted: '))) return;
    await this.answers.refresh();
  }

  private show(states: readonly SavedState[]): void {
    this.names = states.map(({ name }) => name);
    this.nameField.placeholder = freeStateId(this.names.map(stateId));
    const rows = this.rows.show(this.names);
    states.forEach((state, i) => setText(rows[i].facts, stateFacts(state)));
    element('state-list-empty').hidden = states.length > 0;
  }

  private create(name: string): Row {
    const id = stateId(name);
    const facts = make('small', {});
    const title = `Bring ${id} back`;
    const restore = make('button', { type: 'button', className: 'open', title }, make('b', {}, id), facts);
    const label = `Delete ${id}`;
    const remove = make(
      'button',
      { type: 'button', className: 'icon', title: label, 'aria-label': label },
      icon('delete'),
    );
    restore.addEventListener('click', () => void this.restore(name));
    remove.addEventListener('click', () => void this.remove(name));
    return { item: make('li', {}, restore, remove), facts };
  }
}
