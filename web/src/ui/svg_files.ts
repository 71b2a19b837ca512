import type { App } from '../app';
import { svgFault } from '../geometry/svg_fault';
import { element } from './dom';

// kerf.v1.Svg.
const kMaxBytes = 512 * 1024;

/** SVG files that are dropped on the sheet (see FileDrop) or chosen: the cut tool lays them on it. */
export class SvgFiles {
  private readonly input = element<HTMLInputElement>('svg-file');

  constructor(private readonly app: App) {
    this.input.addEventListener('change', () => {
      const file = this.input.files?.[0];
      if (file) void this.take(file);
      // The same file may be chosen again.
      this.input.value = '';
    });
  }

  /** Asks for a file. */
  choose(): void {
    this.input.click();
  }

  async take(file: File): Promise<void> {
    const refuse = (why: string) => this.app.notify('error', `${file.name} ${why}`);
    if (!file.name.toLowerCase().endsWith('.svg') && file.type !== 'image/svg+xml') return refuse('is no SVG drawing');
    if (file.size > kMaxBytes) {
      return refuse(`has ${Math.ceil(file.size / 1024)} KiB; the server takes drawings of at most ${kMaxBytes / 1024}`);
    }
    const text = await file.text().catch(() => undefined);
    if (text === undefined) return refuse('cannot be read');
    const fault = svgFault(text);
    if (fault) return refuse(fault);
    this.app.choose('cut');
    // Refused while a recording is shown.
    if (this.app.tool !== this.app.cutTool) return;
    if (!this.app.cutTool.lay({ name: file.name, text })) return refuse('waits for a sheet: there is none yet');
    this.app.focusStage();
  }
}
