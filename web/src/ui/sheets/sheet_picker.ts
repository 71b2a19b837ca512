import { sheetId } from '../../sheets';
import { element } from '../dom';

/** The choice among the server's sheets; the list is requested again each time it is about to open. */
export class SheetPicker {
  private readonly select = element<HTMLSelectElement>('sheet-picker');

  /** @param asked  the list is about to open */
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
