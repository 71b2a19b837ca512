import { sheetId } from '../../sheets';
import { element } from '../dom';

/** Lets the user choose one of the server's sheets. The list is requested again each time before it opens. */
export class SheetPicker {
  private readonly select = element<HTMLSelectElement>('sheet-picker');

  /** @param asked  called when the list is about to open */
  constructor(chosen: (name: string) => void, asked: () => void) {
    this.select.addEventListener('change', () => chosen(this.select.value));
    this.select.addEventListener('focus', asked);
  }

  /** @param names  sheets/{sheet} */
  show(names: readonly string[], current: string | undefined): void {
    const shown = current && !names.includes(current) ? [...names, current] : names;
    const options = [...this.select.options].map((option) => option.value);
    if (options.join() !== shown.join()) {
      this.select.replaceChildren(...shown.map((name) => new Option(sheetId(name), name)));
    }
    if (current) this.select.value = current;
    this.select.disabled = shown.length === 0;
  }
}
