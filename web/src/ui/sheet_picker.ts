import { element } from './dom';

/** The choice among the server's sheets; the list is asked for anew each time it is about to open. */
export class SheetPicker {
  private readonly select = element<HTMLSelectElement>('sheet-picker');

  constructor(
    private readonly chosen: (name: string) => void,
    list: () => Promise<string[]>,
  ) {
    this.select.addEventListener('change', () => {
      const name = this.select.value;
      const url = new URL(location.href);
      url.searchParams.set('sheet', name.replace('sheets/', ''));
      history.replaceState(null, '', url);
      this.chosen(name);
    });
    this.select.addEventListener('focus', () => void list().then((names) => this.show(names, this.select.value)));
  }

  /** @param names  sheets/{sheet} */
  show(names: readonly string[], current: string | undefined): void {
    const shown = current && !names.includes(current) ? [...names, current] : names;
    const options = [...this.select.options].map((option) => option.value);
    if (options.join() !== shown.join()) {
      this.select.replaceChildren(...shown.map((name) => new Option(name.replace('sheets/', ''), name)));
    }
    if (current) this.select.value = current;
    this.select.disabled = shown.length === 0;
  }
}
