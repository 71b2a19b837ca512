import { svgFault } from '../geometry/svg_fault';
import type { Notifier } from '../notifier';
import { element } from './dom';

/** The tools of the viewer; the cut tool takes a drawing. */
export interface DrawingTools {
  readonly tool: object;
  readonly cut: {
    /** Lays a drawing on the sheet; false if there is no sheet yet. */
    lay(picture: { name: string; text: string }): boolean;
  };
  choose(id: 'cut'): void;
}

// The limit of kerf.v1.Svg.
const kMaxBytes = 512 * 1024;

/** Takes SVG files that are dropped on the sheet (see FileDrop) or chosen; the cut tool lays them on the sheet. */
export class SvgFiles {
  private readonly input = element<HTMLInputElement>('svg-file');

  /** @param done  gives the keyboard focus to the canvas */
  constructor(
    private readonly tools: DrawingTools,
    private readonly notices: Notifier,
    private readonly done: () => void,
  ) {
    this.input.addEventListener('change', () => {
      const file = this.input.files?.[0];
      if (file) void this.take(file);
      // Clears the input, so that the same file can be chosen again.
      this.input.value = '';
    });
  }

  /** Lets the user choose a file. */
  choose(): void {
    this.input.click();
  }

  async take(file: File): Promise<void> {
    const refuse = (why: string) => this.notices.notify('error', `${file.name} ${why}`);
    if (!file.name.toLowerCase().endsWith('.svg') && file.type !== 'image/svg+xml') return refuse('is not an SVG drawing');
    if (file.size > kMaxBytes) {
      return refuse(`has ${Math.ceil(file.size / 1024)} KiB; the server accepts drawings of at most ${kMaxBytes / 1024}`);
    }
    const text = await file.text().catch(() => undefined);
    if (text === undefined) return refuse('cannot be read');
    const fault = svgFault(text);
    if (fault) return refuse(fault);
    const { tools } = this;
    tools.choose('cut');
    // The cut tool cannot be chosen while a recording is shown, or without rights.
    if (tools.tool !== tools.cut) return;
    if (!tools.cut.lay({ name: file.name, text })) return refuse('waits for a sheet: there is none yet');
    this.done();
  }
}
