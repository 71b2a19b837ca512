import { element } from './dom';
import { isRecordingFile } from './replay_bar';
import { isRunFile } from './server_recordings';

/** Actions for a file dropped on the sheet, by its kind. */
export interface FileTakers {
  /** Makes a new sheet. */
  mesh(file: File): void;
  /** Plays recorded frames in the page. */
  frames(file: File): void;
  /** Lets the server play its recording as a new sheet. */
  run(file: File): void;
  /** Takes any other file as a drawing to cut along. */
  drawing(file: File): void;
}

function hasFiles({ dataTransfer }: DragEvent): boolean {
  return dataTransfer?.types.includes('Files') ?? false;
}

// Ignores a file dropped elsewhere; otherwise the browser would leave the page to show it.
function keepPage(event: DragEvent): void {
  if (event.defaultPrevented || !hasFiles(event)) return;
  event.preventDefault();
  event.dataTransfer!.dropEffect = 'none';
}

/** Takes files that are dropped on the sheet. */
export class FileDrop {
  constructor(takers: FileTakers) {
    for (const name of ['dragover', 'drop'] as const) addEventListener(name, keepPage);
    const stage = element('stage');
    stage.addEventListener('dragover', (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      stage.classList.add('dropping');
    });
    for (const name of ['dragleave', 'drop']) stage.addEventListener(name, () => stage.classList.remove('dropping'));
    stage.addEventListener('drop', (event) => {
      const file = event.dataTransfer?.files[0];
      if (!file) return;
      event.preventDefault();
      if (/\.(obj|ply)$/i.test(file.name)) takers.mesh(file);
      else if (isRecordingFile(file)) takers.frames(file);
      else if (isRunFile(file)) takers.run(file);
      else takers.drawing(file);
    });
  }
}
