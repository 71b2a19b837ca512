import { App } from './app';
import { installHooks } from './hooks';
import { element } from './ui/dom';
import { FileDrop } from './ui/file_drop';
import { bindKeys } from './ui/keys';
import { ServerRecordings } from './ui/server_recordings';
import { SheetChoice } from './ui/sheets/sheet_choice';
import { markTabbedFocus } from './ui/tabbed_focus';

async function start(): Promise<void> {
  const app = new App();
  installHooks(app, element<HTMLCanvasElement>('canvas'));
  const sheets = new SheetChoice(app);
  app.panels.add('sheets', sheets);
  const recordings = new ServerRecordings(app, (name) => sheets.open(name));
  new FileDrop({
    mesh: (file) => void sheets.dialog.open(file),
    frames: (file) => void app.replayBar.open(file),
    run: (file) => void recordings.play(file),
    drawing: (file) => void app.svgFiles.take(file),
  });
  bindKeys(app);
  markTabbedFocus(element('canvas'));
  await sheets.start();
}

start().catch((error: Error) => {
  const line = element('connection-detail');
  line.hidden = false;
  line.textContent = `The viewer cannot start: ${error.message}`;
});
