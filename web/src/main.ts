import { ApiError, call } from './api';
import { App } from './app';
import { SheetService } from './gen/kerf/v1/sheets_pb';
import { installHooks } from './hooks';
import { element } from './ui/dom';
import { bindKeys } from './ui/keys';
import { SheetPicker } from './ui/sheet_picker';

const kListRetryMs = 1000;

/** The sheets of this server; waits until it can be reached. */
async function listSheets(app: App): Promise<string[]> {
  for (;;) {
    try {
      const names: string[] = [];
      let pageToken = '';
      do {
        const page = await call(SheetService.method.listSheets, { pageToken });
        names.push(...page.sheets.map((sheet) => sheet.name));
        pageToken = page.nextPageToken;
      } while (pageToken !== '');
      return names;
    } catch (error) {
      const { code, message } = error as ApiError;
      app.showConnection('lost', `${message}${code === 'UNAVAILABLE' ? '' : ` (${code})`}; trying again`);
      await new Promise((resolve) => setTimeout(resolve, kListRetryMs));
    }
  }
}

async function start(): Promise<void> {
  const app = new App();
  installHooks(app, element<HTMLCanvasElement>('canvas'));
  bindKeys(app);
  const picker = new SheetPicker(
    (name) => app.open(name),
    () => listSheets(app),
  );
  const names = await listSheets(app);
  const asked = new URLSearchParams(location.search).get('sheet');
  // A sheet that was asked for and is not there is opened all the same: the server says what is wrong.
  const name = asked ? `sheets/${asked}` : names.includes('sheets/demo') ? 'sheets/demo' : names[0];
  picker.show(names, name);
  if (name) app.open(name);
  else
    app.showConnection(
      'ended',
      'This server has no sheets. Create one: kerf sheet create demo --grid 50x50 --size 1x1',
    );
}

start().catch((error: Error) => {
  const line = element('connection-detail');
  line.hidden = false;
  line.textContent = `The viewer cannot start: ${error.message}`;
});
