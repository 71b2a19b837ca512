import { sendFile } from '../../api';
import { MeshReportSchema } from '../../gen/kerf/v1/files_pb';
import type { MeshReport } from '../../gen/kerf/v1/files_pb';
import { element, make } from '../dom';
import { errorText } from '../error_text';
import { inspectPath, reportLines } from './mesh_reading';
import type { MeshChoices, MeshFile, ReportLine } from './mesh_reading';

/** Fields of the form that say how a mesh file is read, and what the server finds in it. */
export class MeshPreview {
  private readonly unit = element<HTMLSelectElement>('new-unit');
  private readonly up = element<HTMLSelectElement>('new-up');
  private readonly object = element<HTMLSelectElement>('new-object');
  private readonly texture = element<HTMLInputElement>('new-texture');
  private readonly list = element('new-report');
  private asking: AbortController | undefined;
  private file: MeshFile | undefined;

  /** @param mostBytes  returns the size of the largest mesh file that the server takes */
  constructor(private readonly mostBytes: () => number) {
    for (const field of [this.unit, this.up, this.object, this.texture]) {
      field.addEventListener('change', () => void this.ask());
    }
  }

  get choices(): MeshChoices {
    return {
      unitM: Number(this.unit.value),
      up: this.up.value as MeshChoices['up'],
      object: this.object.value,
      ignoresTexture: this.texture.checked,
    };
  }

  /** Takes another file, or none. Choices of the last one stay, except its object. */
  async take(file: MeshFile | undefined): Promise<void> {
    this.file = file;
    this.object.replaceChildren(new Option('all', ''));
    this.object.parentElement!.hidden = true;
    await this.ask();
  }

  private async ask(): Promise<void> {
    this.asking?.abort();
    this.show([]);
    const { file } = this;
    if (!file || file.content.size > this.mostBytes()) return; // The form says that it is too large.
    const asking = new AbortController();
    this.asking = asking;
    try {
      const path = inspectPath(file, this.choices);
      const onProgress = (share: number) => {
        if (!asking.signal.aborted) this.show([{ kind: 'note', text: `looking into the file: ${Math.floor(100 * share)} % sent` }]);
      };
      const sending = { signal: asking.signal, onProgress };
      const report = await sendFile(MeshReportSchema, path, file.content, sending);
      if (asking.signal.aborted) return;
      this.listObjects(report);
      this.show(reportLines(report));
    } catch (error) {
      if (!asking.signal.aborted) this.show([{ kind: 'fault', text: errorText(error as Error) }]);
    }
  }

  private listObjects({ objects }: MeshReport): void {
    if (this.object.options.length > 1 || objects.length < 2) return;
    this.object.append(...objects.map(({ name, faces }) => new Option(`${name} (${faces.toLocaleString('en')})`, name)));
    this.object.parentElement!.hidden = false;
  }

  private show(lines: ReportLine[]): void {
    this.list.replaceChildren(...lines.map(({ kind, text }) => make('li', { className: kind }, text)));
  }
}
