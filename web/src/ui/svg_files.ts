import type { App } from '../app';
import { element } from './dom';

// kerf.v1.Svg.
const kMaxBytes = 512 * 1024;

/** SVG files that are dropped on the sheet or chosen: the cut tool lays them on it. */
export class SvgFiles {
  private readonly input = element<HTMLInputElement>('svg-file');

  constructor(private readonly app: App) {
    const stage = element('stage');
    this.input.addEventListener('change', () => {
      void this.take(this.input.files);
      // The same file may be chosen again.
      this.input.value = '';
    });
    stage.addEventListener('dragover', (event) => {
      if (!event.dataTransfer?.types.includes('Files')) return;
      event.preventDefault();
      stage.classList.add('dropping');
    });
    for (const name of ['dragleave', 'drop']) stage.addEventListener(name, () => stage.classList.remove('dropping'));
    stage.addEventListener('drop', (event) => {
      if (!event.dataTransfer?.files.length) return;
      event.preventDefault();
      void this.take(event.dataTransfer.files);
    });
  }

  /** Asks for a file. */
  choose(): void {
    this.input.click();
  }

  private async take(files: FileList | null): Promise<void> {
    const file = files?.[0];
    if (!file) return;
    const refuse = (why: string) => this.app.notify('error', `${file.name} ${why}`);
    if (!file.name.toLowerCase().endsWith('.svg') && file.type !== 'image/svg+xml') return refuse('is no SVG drawing');
    if (file.size > kMaxBytes) {
      return refuse(`has ${Math.ceil(file.size / 1024)} KiB; the server takes drawings of at most ${kMaxBytes / 1024}`);
    }
    const text = await file.text().catch(() => undefined);
    if (text === undefined) return refuse('cannot be read');
    this.app.choose('cut');
    if (!this.app.cutTool.lay({ name: file.name, text })) return refuse('waits for a sheet: there is none yet');
    this.app.focusStage();
  }
}
