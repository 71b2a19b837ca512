import { call, requestBody, sendFile } from '../../api';
import type { ServerInfo } from '../../gen/kerf/v1/server_pb';
import { CreateSheetRequestSchema, SheetSchema, SheetService } from '../../gen/kerf/v1/sheets_pb';
import type { Sheet } from '../../gen/kerf/v1/sheets_pb';
import { svgFault } from '../../geometry/svg_fault';
import { serverInfo } from '../../server_info';
import { countText, sizeText } from '../../tools/cut_text';
import { element, make, setText } from '../dom';
import { errorText } from '../error_text';
import { materialFacts } from '../material_text';
import { formErrors, nameError, refusal } from './form_checks';
import { MeshPreview } from './mesh_preview';
import type { MeshFile } from './mesh_reading';
import { createRequest, uploadPath } from './new_sheet';
import type { Hang, NewShape, NewSheet, Outline } from './new_sheet';
import { outlineParts } from './outline_parts';
import type { OutlineParts } from './outline_parts';
import { scaledOutline } from './scaled_drawing';
import { idFrom } from './sheet_ids';

function fieldOf<T extends HTMLElement = HTMLInputElement>(name: string): T {
  return element<T>(`new-${name}`);
}

/** The form for a new sheet, which it then creates: a grid, a mesh file or the outline of a drawing. */
export class NewSheetDialog {
  private readonly dialog = element<HTMLDialogElement>('new-sheet');
  private readonly form = this.dialog.querySelector('form')!;
  private readonly progress = element<HTMLProgressElement>('new-progress');
  private info: ServerInfo | undefined;
  private mesh: MeshFile | undefined;
  private readonly preview = new MeshPreview(() => Number(this.info?.limits?.maxMeshUploadBytes ?? Infinity));
  private drawing: { name: string; parts: OutlineParts } | undefined;
  private sending: AbortController | undefined;

  /** @param created  called with sheets/{sheet} once it exists */
  constructor(private readonly created: (name: string) => void) {
    this.form.addEventListener('submit', (event) => {
      event.preventDefault();
      void this.create();
    });
    this.form.addEventListener('input', ({ target }) => {
      this.clearError((target as HTMLElement).id.replace('new-', ''));
      if (target === fieldOf('id')) this.checkName();
      this.update();
    });
    this.dialog.querySelector('[data-close]')!.addEventListener('click', () => this.dialog.close());
    this.dialog.addEventListener('close', () => this.sending?.abort());
    for (const name of ['file', 'outline']) {
      const input = fieldOf(name);
      input.addEventListener('change', () => void (input.files?.[0] && this.take(input.files[0])));
    }
    this.dialog.addEventListener('dragover', (event) => event.preventDefault());
    this.dialog.addEventListener('drop', (event) => {
      event.preventDefault();
      const file = event.dataTransfer?.files[0];
      if (file) void this.take(file);
    });
  }

  /** @param file  a mesh or a drawing to begin with */
  async open(file?: File): Promise<void> {
    this.clearErrors();
    this.update();
    if (!this.dialog.open) this.dialog.showModal();
    if (file) await this.take(file);
    await this.fetchInfo();
  }

  // Fetches materials and limits of this server.
  private async fetchInfo(): Promise<void> {
    try {
      this.info = await serverInfo();
    } catch (error) {
      this.showError('', errorText(error as Error));
      return;
    }
    const select = fieldOf<HTMLSelectElement>('material');
    if (select.options.length === 0) {
      select.append(...this.info.materialPresets.map((preset) => new Option(preset, preset)));
    }
    this.update();
  }

  // Takes a file. A fault is shown at its field, which gets the focus unless the user has begun to type elsewhere.
  private async take(file: File): Promise<void> {
    const { activeElement } = document;
    await this.readFile(file);
    if (document.activeElement === activeElement) this.focusError();
  }

  private async readFile(file: File): Promise<void> {
    const ending = file.name.toLowerCase().split('.').at(-1);
    const name = ending === 'svg' ? 'outline' : 'file';
    this.choose(name === 'outline' ? 'outline' : 'file');
    // Clears a refused name, so that the file can suggest one.
    if (fieldOf('id').getAttribute('aria-invalid') === 'true') fieldOf('id').value = '';
    this.clearErrors();
    if (ending === 'svg') {
      const text = await file.text().catch(() => undefined);
      if (text === undefined) return this.showError(name, `${file.name} cannot be read: choose it again`);
      this.drawing = this.partsOf(file.name, text);
      if (!this.drawing) return this.update();
    } else if (ending === 'obj' || ending === 'ply') {
      this.mesh = { name: file.name, kind: ending, content: file };
      void this.preview.take(this.mesh);
    } else {
      return this.showError(name, `${file.name} is not an OBJ, PLY or SVG file: choose another one`);
    }
    if (fieldOf('id').value === '') fieldOf('id').value = idFrom(file.name);
    this.update();
  }

  // Undefined if the drawing's lines form no sheet; the field then shows the reason.
  private partsOf(name: string, text: string): typeof this.drawing {
    const refuse = (why: string) => void this.showError('outline', `${name} ${why}`);
    const fault = svgFault(text);
    if (fault) return refuse(fault);
    try {
      return { name, parts: outlineParts(text) };
    } catch (error) {
      return refuse((error as Error).message);
    }
  }

  private choose(shape: NewShape): void {
    this.form.querySelector<HTMLInputElement>(`[name=shape][value=${shape}]`)!.checked = true;
  }

  private read(): NewSheet {
    const chosen = (name: string) => this.form.querySelector<HTMLInputElement>(`[name=${name}]:checked`)!.value;
    const number = (name: string) => fieldOf(name).valueAsNumber;
    const shape = chosen('shape') as NewShape;
    const outlineWidthM = number('outline-width');
    return {
      id: fieldOf('id').value.trim(),
      shape,
      columns: number('columns'),
      rows: number('rows'),
      widthM: number('width'),
      heightM: number('height'),
      file: this.mesh,
      mesh: this.preview.choices,
      outline: shape === 'outline' ? this.outline(outlineWidthM) : undefined,
      outlineWidthM,
      hang: chosen('hang') as Hang,
      material: fieldOf<HTMLSelectElement>('material').value,
      fidelity: Number(fieldOf<HTMLSelectElement>('fidelity').value),
      pins: Number(fieldOf<HTMLSelectElement>('pins').value),
      hasFloor: fieldOf('floor').checked,
      hasBall: fieldOf('ball').checked,
      isPaused: fieldOf('paused').checked,
    };
  }

  // Undefined without a drawing, or if it has no size; the field then shows the reason.
  private outline(widthM: number): Outline | undefined {
    if (!this.drawing || !(widthM > 0)) return undefined;
    try {
      return scaledOutline(this.drawing.parts, widthM);
    } catch (error) {
      this.showError('outline', `${this.drawing.name} ${(error as Error).message}`);
      return undefined;
    }
  }

  private update(): void {
    const form = this.read();
    for (const shape of ['grid', 'file', 'outline']) fieldOf(`shape-${shape}`).hidden = form.shape !== shape;
    const vertices = form.columns * form.rows;
    setText(fieldOf('vertices'), Number.isFinite(vertices) ? `${vertices.toLocaleString('en')} vertices` : '');
    setText(fieldOf('file-name'), this.mesh ? `${this.mesh.name}, ${sizeText(this.mesh.content.size)}` : 'none chosen');
    setText(fieldOf('outline-name'), this.drawingText());
    this.showMaterial(form.material);
    // A mesh file has its own place, so there is no choice of its position or of a ball.
    fieldOf('hang').hidden = form.shape === 'file';
    fieldOf('ball').disabled = form.shape === 'file';
  }

  private drawingText(): string {
    if (!this.drawing) return 'none chosen';
    const { name, parts } = this.drawing;
    return parts.numHoles > 0 ? `${name}, with ${countText(parts.numHoles, 'hole')}` : name;
  }

  private async create(): Promise<void> {
    this.clearErrors();
    const form = this.read();
    this.check(form);
    if (this.form.querySelector('[aria-invalid=true]')) return this.focusError();
    const request = createRequest(form);
    if (!this.fits(form, requestBody(CreateSheetRequestSchema, request).length)) return this.focusError();
    const sending = new AbortController();
    this.sending = sending;
    this.setBusy(true);
    try {
      const sheet = await this.send(form, request, sending.signal);
      this.sending = undefined;
      this.forgetFiles();
      this.dialog.close();
      this.created(sheet.name);
    } catch (error) {
      // The user has cancelled by closing the form, so nothing is reported.
      if (sending.signal.aborted) return;
      this.showError(...refusal(error as Error, form));
      this.focusError();
    } finally {
      this.sending = undefined;
      this.setBusy(false);
    }
  }

  private send({ shape, file }: NewSheet, request: ReturnType<typeof createRequest>, signal: AbortSignal): Promise<Sheet> {
    const onProgress = (part: number) => this.showProgress(part);
    if (shape === 'file' && file) return sendFile(SheetSchema, uploadPath(file, request), file.content, { signal, onProgress });
    return call(SheetService.method.createSheet, request, { signal, onProgress });
  }

  // Clears the name and files, which are for one sheet; numbers and choices stay for the next.
  private forgetFiles(): void {
    for (const name of ['id', 'file', 'outline']) fieldOf(name).value = '';
    this.mesh = undefined;
    void this.preview.take(undefined);
    this.drawing = undefined;
  }

  private check(form: NewSheet): void {
    const mostVertices = this.info?.limits?.maxVerticesPerSheet ?? Infinity;
    for (const [name, text] of formErrors(form, this.drawing !== undefined, mostVertices)) this.showError(name, text);
  }

  // Checks the name while it is typed.
  private checkName(): void {
    const wrong = nameError(fieldOf('id').value.trim());
    if (wrong) this.showError('id', wrong);
  }

  // Checks sizes that the server would refuse only after all was sent. Requests are ASCII except for names, so a
  // character is about a byte.
  private fits({ shape, file }: NewSheet, numBytes: number): boolean {
    const limits = this.info?.limits;
    const [name, size, limit] =
      shape === 'file'
        ? ['file', file?.content.size ?? 0, Number(limits?.maxMeshUploadBytes ?? Infinity)]
        : ['outline', numBytes, limits?.maxRequestBytes ?? Infinity];
    if (size <= limit) return true;
    const what = shape === 'file' ? 'This file has' : 'This drawing makes a request of';
    this.showError(name, `${what} ${sizeText(size)}, but the server accepts at most ${sizeText(limit)}: choose a coarser one`);
    return false;
  }

  private showMaterial(preset: string): void {
    const material = this.info?.materials.find((each) => each.preset === preset);
    const facts = material ? materialFacts(material) : [];
    const rows = facts.map(([name, value]) => make('div', {}, make('dt', {}, name), make('dd', {}, value)));
    fieldOf('material-facts').replaceChildren(...rows);
  }

  // Shows the share sent. Once all is sent, the server makes the sheet, which takes an unknown time.
  private showProgress(part: number): void {
    if (part < 1) this.progress.value = part;
    else this.progress.removeAttribute('value');
  }

  private setBusy(isBusy: boolean): void {
    this.progress.hidden = !isBusy;
    this.progress.value = 0;
    fieldOf<HTMLButtonElement>('create').disabled = isBusy;
  }

  // Shows an error under its field, or under the form if `name` is empty.
  private showError(name: string, text: string): void {
    const line = element(name === '' ? 'new-error' : `new-${name}-error`);
    setText(line, text);
    line.hidden = false;
    if (name !== '') fieldOf(name).setAttribute('aria-invalid', 'true');
  }

  // Moves the focus to the first field with an error. Not to be called while the user types.
  private focusError(): void {
    this.form.querySelector<HTMLElement>('[aria-invalid=true]')?.focus();
  }

  private clearErrors(): void {
    for (const line of this.form.querySelectorAll<HTMLElement>('.error')) line.hidden = true;
    for (const field of this.form.querySelectorAll('[aria-invalid]')) field.removeAttribute('aria-invalid');
  }

  private clearError(name: string): void {
    const line = document.getElementById(`new-${name}-error`);
    if (line) line.hidden = true;
    document.getElementById(`new-${name}`)?.removeAttribute('aria-invalid');
  }
}
