import { element } from './dom';
import { isRecordingFile } from './replay_bar';

/**
 * Files that are dropped on the sheet: a mesh becomes a new one, a recording is played, anything else is taken for a drawing
 * to cut along.
 */
export class FileDrop {
  constructor(drawing: (file: File) => void, mesh: (file: File) => void, recording: (file: File) => void) {
    const stage = element('stage');
    stage.addEventListener('dragover', (event) => {
      if (!event.dataTransfer?.types.includes('Files')) return;
      event.preventDefault();
      stage.classList.add('dropping');
    });
    for (const name of ['dragleave', 'drop']) stage.addEventListener(name, () => stage.classList.remove('dropping'));
    stage.addEventListener('drop', (event) => {
      const file = event.dataTransfer?.files[0];
      if (!file) return;
      event.preventDefault();
      if (/\.(obj|ply)$/i.test(file.name)) mesh(file);
      else if (isRecordingFile(file)) recording(file);
      else drawing(file);
    });
  }
}
