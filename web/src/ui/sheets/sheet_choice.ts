import { call } from '../../api';
import type { ApiError } from '../../api';
import { Scope } from '../../gen/kerf/v1/access_service_pb';
import { SheetService } from '../../gen/kerf/v1/sheets_pb';
import type { Sheet } from '../../gen/kerf/v1/sheets_pb';
import { NewestAnswer } from '../../newest_answer';
import type { Reporter } from '../../notifier';
import type { OpenSheet } from '../../sheet/open_sheet';
import { listSheets, sheetId } from '../../sheets';
import type { Rights } from '../access/rights';
import { confirmed } from '../confirmation';
import type { ConnectionChip } from '../connection_chip';
import { element } from '../dom';
import { errorText } from '../error_text';
import { Polling } from '../polling';
import type { SheetOpener } from '../sheet_opener';
import type { Panel, SidePanels } from '../side_panels';
import { withoutView } from '../view_link';
import { NewSheetDialog } from './new_sheet_dialog';
import { SheetList } from './sheet_list';
import { SheetPicker } from './sheet_picker';

const kRetryMs = 1000;
// Period of updates while the panel is open.
const kListPeriodMs = 1500;

/** The parts of the viewer that show a chosen sheet. */
export interface ChoosingParts {
  readonly live: Pick<OpenSheet, 'sheetName'>;
  readonly opener: Pick<SheetOpener, 'open' | 'offer' | 'close'>;
  readonly replayBar: { readonly hasFile: boolean };
  readonly connection: Pick<ConnectionChip, 'show'>;
  readonly panels: Pick<SidePanels, 'open' | 'toggle'>;
  readonly notices: Reporter;
  readonly rights: Pick<Rights, 'may'>;
  /** Gives the keyboard focus to the canvas. */
  focusStage(): void;
}

/**
 * Chooses the watched sheet by the page's address, the picker or the panel of all sheets. The panel also makes and
 * deletes sheets.
 */
export class SheetChoice implements Panel {
  readonly dialog = new NewSheetDialog((name) => {
    this.open(name);
    this.parts.focusStage();
  });
  private readonly picker: SheetPicker;
  private readonly list: SheetList;
  private sheets: readonly Sheet[] = [];
  // Keeps the list while the server cannot be reached, which the connection chip shows.
  private readonly answers = new NewestAnswer(listSheets, (sheets) => this.show(sheets));
  private readonly polling = new Polling(() => this.answers.fetch(), kListPeriodMs);

  constructor(private readonly parts: ChoosingParts) {
    this.picker = new SheetPicker(
      (name) => this.open(name),
      () => void this.answers.fetch(),
    );
    this.list = new SheetList(
      element('sheet-list'),
      (name) => this.open(name),
      (name) => void this.remove(name),
    );
    element('new-sheet-open').addEventListener('click', () => void this.dialog.open());
  }

  opened(): void {
    this.polling.start();
  }

  closed(): void {
    this.polling.stop();
  }

  /** Opens the sheet named in the address, else `demo`, else the first. Waits until the server can be reached. */
  async start(): Promise<void> {
    const sheets = await this.reachable();
    const names = sheets.map((sheet) => sheet.name);
    const asked = new URLSearchParams(location.search).get('sheet');
    // Opens a sheet named in the address even if it does not exist, so that the server reports the error.
    const name = asked ? `sheets/${asked}` : names.includes('sheets/demo') ? 'sheets/demo' : names[0];
    if (name) this.parts.opener.offer(name);
    this.show(sheets);
    if (!name) this.showNone();
  }

  /** Watches this sheet and writes its name into the address. */
  open(name: string): void {
    const url = withoutView(new URL(location.href));
    url.searchParams.set('sheet', sheetId(name));
    history.replaceState(null, '', url);
    this.parts.opener.open(name);
    void this.answers.fetch();
  }

  /** Asks for the list again, because others may be seen after a login. */
  refresh(): void {
    void this.answers.fetch();
  }

  private async remove(name: string): Promise<void> {
    const question = `Delete the sheet ${sheetId(name)}? It ends for everyone who watches it, and cannot be restored.`;
    if (!(await confirmed(question, 'Delete'))) return;
    const { live, notices } = this.parts;
    const deletion = () => call(SheetService.method.deleteSheet, { name });
    if (!(await notices.attempt(deletion, 'Nothing was deleted: '))) return;
    notices.notify('info', `Deleted ${sheetId(name)}`);
    const isListed = await this.answers.refresh();
    if (name !== live.sheetName || !isListed) return;
    if (this.sheets.length > 0) this.open(this.sheets[0].name);
    else this.showNone();
  }

  private showNone(): void {
    const { opener, replayBar, connection, panels, rights } = this.parts;
    opener.close();
    if (replayBar.hasFile) return;
    const mayCreate = rights.may(Scope.ADMIN);
    connection.show('ended', mayCreate ? 'This server has no sheets: create one under Sheets, New sheet' : 'There is no sheet for you');
    if (panels.open !== 'sheets') panels.toggle('sheets');
  }

  private show(sheets: readonly Sheet[]): void {
    this.sheets = sheets;
    const { sheetName } = this.parts.live;
    this.picker.show(
      sheets.map((sheet) => sheet.name),
      sheetName || undefined,
    );
    this.list.show(sheets, sheetName);
    element('sheet-list-empty').hidden = sheets.length > 0;
  }

  private async reachable(): Promise<Sheet[]> {
    for (;;) {
      try {
        return await listSheets();
      } catch (error) {
        this.parts.connection.show('lost', `${errorText(error as ApiError)}; trying again`);
        await new Promise((resolve) => setTimeout(resolve, kRetryMs));
      }
    }
  }
}
