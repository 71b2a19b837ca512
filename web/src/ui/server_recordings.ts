import { fetchFile, sendFile } from '../api';
import { SheetSchema } from '../gen/kerf/v1/sheets_pb';
import type { Notifier } from '../notifier';
import { serverInfo } from '../server_info';
import type { OpenSheet, ShownState } from '../sheet/open_sheet';
import { listSheets, sheetId } from '../sheets';
import { countText, sizeText } from '../tools/cut_text';
import { element } from './dom';
import { fileName, saveFile } from './download';
import { freeId, idFrom } from './sheets/sheet_ids';
import type { Transfer } from './transfer';

export function isRunFile(file: File): boolean {
  return file.name.toLowerCase().endsWith('.rec');
}

/** The parts of the viewer that send and fetch the server's recordings. */
export interface RecordingParts {
  readonly live: Pick<OpenSheet, 'sheetName'>;
  readonly shown: Pick<ShownState, 'surface'>;
  readonly transfer: Pick<Transfer, 'run'>;
  readonly notices: Notifier;
}

/** Saves the server's recording of a sheet's run as a file, and lets the server play such a file as a new sheet. */
export class ServerRecordings {
  private readonly input = element<HTMLInputElement>('run-file');

  /** @param opened  called with the sheets/{sheet} that plays a recording */
  constructor(
    private readonly parts: RecordingParts,
    private readonly opened: (name: string) => void,
  ) {
    element('save-run').addEventListener('click', () => void this.save());
    element('play-run').addEventListener('click', () => this.input.click());
    this.input.addEventListener('change', () => {
      const file = this.input.files?.[0];
      // Clears the input, so that the same file can be chosen again.
      this.input.value = '';
      if (file) void this.play(file);
    });
  }

  async play(file: File): Promise<void> {
    const { notices, transfer } = this.parts;
    const failed = `${file.name} is not played: `;
    if (!isRunFile(file)) return notices.notify('error', `${failed}a recording made by the server ends in .rec`);
    const sheet = await transfer.run(`Sending ${file.name}`, failed, async (options) => {
      const limit = Number((await serverInfo()).limits?.maxRecordingUploadBytes ?? 0);
      if (file.size > limit) throw new Error(`it has ${sizeText(file.size)}; the server accepts ${sizeText(limit)}`);
      const taken = (await listSheets()).map(({ name }) => sheetId(name));
      const id = freeId(idFrom(file.name) || 'recording', taken);
      return sendFile(SheetSchema, `/recordings?sheet=${id}`, file, options);
    });
    if (!sheet) return;
    this.opened(sheet.name);
    const ticks = countText(Number(sheet.replay?.endTick ?? 0), 'tick');
    const torn = Number(sheet.replay?.tornBytes ?? 0);
    const left = torn > 0 ? `; its last ${countText(torn, 'byte')}, an incomplete entry, left out` : '';
    notices.notify('success', `${sheetId(sheet.name)} plays ${file.name}, ${ticks}${left}: it takes no commands until the end`);
  }

  private async save(): Promise<void> {
    const { live, notices, shown, transfer } = this.parts;
    const { sheetName } = live;
    const name = fileName(sheetName, shown.surface?.mirror.tick ?? 0, 'rec');
    const parts = await transfer.run(`Fetching ${name}`, 'The recording was not saved: ', (options) =>
      fetchFile(`/${sheetName}.rec`, options),
    );
    if (parts) notices.notify('success', saveFile(parts, name, 'application/octet-stream'));
  }
}
