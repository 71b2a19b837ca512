import { svgFault } from '../geometry/svg_fault';
import type { Reporter } from '../notifier';
import { drawingContent } from '../tools/drawings/drawing_content';
import type { DrawingContent } from '../tools/drawings/drawing_content';
import type { Picture } from '../tools/drawings/picture_drawing';
import { readPicture } from '../tools/drawings/picture_reader';
import { element } from './dom';

/** The tools of the viewer; the cut tool takes a drawing. */
export interface DrawingTools {
  readonly tool: object;
  readonly cut: {
    /** Lays a drawing on the sheet; false if there is no sheet yet. */
    lay(picture: Picture): boolean;
  };
  choose(id: 'cut'): void;
}

// Limits of kerf.v1.Svg, without embedded pictures, and of a file with them.
const kMaxTextBytes = 512 * 1024;
const kMaxFileBytes = 16 * 1024 * 1024;

/** Takes drawings, SVG or DXF, that are dropped on the sheet (see FileDrop) or chosen; the cut tool lays them on the sheet. */
export class SvgFiles {
  private readonly input = element<HTMLInputElement>('svg-file');

  /** @param done  gives the keyboard focus to the canvas */
  constructor(
    private readonly tools: DrawingTools,
    private readonly notices: Reporter,
    private readonly done: () => void,
    private readonly read: (name: string, content: DrawingContent) => Promise<Picture> = readPicture,
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
    if (!/\.(svgz?|dxf)$/i.test(file.name) && file.type !== 'image/svg+xml') return refuse('is neither SVG nor DXF');
    if (file.size > kMaxFileBytes) {
      return refuse(`has ${Math.ceil(file.size / 1024)} KiB; the limit is ${kMaxFileBytes / 1024}`);
    }
    const content = await drawingContent(file).catch(() => undefined);
    if (content === undefined) return refuse('cannot be read');
    if (content.case === 'svg') {
      const { length } = content.value.text;
      if (length > kMaxTextBytes) {
        return refuse(`has ${Math.ceil(length / 1024)} KiB; the server accepts drawings of at most ${kMaxTextBytes / 1024}`);
      }
      const fault = svgFault(content.value.text);
      if (fault) return refuse(fault);
    }
    const picture = await this.notices.attempt(() => this.read(file.name, content), `${file.name}: `);
    if (!picture) return;
    const { tools } = this;
    tools.choose('cut');
    // The cut tool cannot be chosen while a recording is shown, or without rights.
    if (tools.tool !== tools.cut) return;
    if (!tools.cut.lay(picture)) return refuse('waits for a sheet: there is none yet');
    this.done();
  }
}
