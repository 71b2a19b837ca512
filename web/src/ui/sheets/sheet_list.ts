import { Replay_State, Sheet_RunState } from '../../gen/kerf/v1/sheets_pb';
import type { Sheet } from '../../gen/kerf/v1/sheets_pb';
import { runStateText, sheetId } from '../../sheets';
import { countText } from '../../tools/cut_text';
import { icon, make, setText } from '../dom';
import { KeptRows } from '../kept_rows';
import type { KeptRow } from '../kept_rows';

/** Returns "2,500 vertices, 1 piece, 0.98 × real time"; the factor only for a running sheet. */
export function sheetFacts(sheet: Sheet): string {
  const facts = [countText(sheet.numVertices, 'vertex', 'vertices'), countText(sheet.pieces, 'piece')];
  if (sheet.runState === Sheet_RunState.RUNNING) facts.push(`${sheet.realTimeFactor.toFixed(2)} × real time`);
  const { replay, tick } = sheet;
  if (replay?.state === Replay_State.PLAYING) facts.push(`plays tick ${tick} of ${replay.endTick}`);
  return facts.join(', ');
}

interface Row extends KeptRow {
  open: HTMLButtonElement;
  state: HTMLElement;
  facts: HTMLElement;
}

/** The list of sheets, with one row each. */
export class SheetList {
  private readonly rows: KeptRows<string, Row>;

  constructor(
    list: HTMLElement,
    private readonly opened: (name: string) => void,
    private readonly removed: (name: string) => void,
  ) {
    this.rows = new KeptRows(list, (name) => this.create(name));
  }

  /** @param current  sheets/{sheet} that this page watches */
  show(sheets: readonly Sheet[], current: string): void {
    const rows = this.rows.show(sheets.map((sheet) => sheet.name));
    sheets.forEach((sheet, i) => {
      const row = rows[i];
      if (sheet.name === current) row.open.setAttribute('aria-current', 'true');
      else row.open.removeAttribute('aria-current');
      row.state.dataset.state = runStateText(sheet.runState).replace(' ', '-');
      setText(row.state, runStateText(sheet.runState));
      setText(row.facts, sheetFacts(sheet));
    });
  }

  private create(name: string): Row {
    const state = make('span', { className: 'badge' });
    const facts = make('small', {});
    const title = `Watch ${sheetId(name)}`;
    const open = make('button', { type: 'button', className: 'open', title }, make('b', {}, sheetId(name)), state, facts);
    const label = `Delete ${sheetId(name)}`;
    const remove = make(
      'button',
      { type: 'button', className: 'icon', title: label, 'aria-label': label, 'data-needs': 'admin' },
      icon('delete'),
    );
    open.addEventListener('click', () => this.opened(name));
    remove.addEventListener('click', () => this.removed(name));
    return { item: make('li', {}, open, remove), open, state, facts };
  }
}
