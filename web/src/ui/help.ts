import { make } from './dom';
import type { ShortcutGroup } from './shortcut';

/** The help page of keys, made from the table by which keys are bound. */
export class Help {
  constructor(private readonly dialog: HTMLDialogElement) {
    dialog.addEventListener('click', (event) => {
      if (event.target === dialog) dialog.close();
    });
  }

  fill(groups: readonly ShortcutGroup[]): void {
    const sections = groups.map(({ title, intro, shortcuts }) => {
      const rows = shortcuts.flatMap(({ chords, what }) => [make('dt', {}, ...keycaps(chords)), make('dd', {}, what)]);
      return make('section', {}, make('h3', {}, title), ...(intro ? [make('p', {}, intro)] : []), make('dl', {}, ...rows));
    });
    this.dialog.querySelector('.shortcuts')!.replaceChildren(...sections);
  }

  open(): void {
    this.dialog.showModal();
    // Scrolls to the top, because the focus is on the last line.
    this.dialog.scrollTop = 0;
  }
}

function keycaps(chords: readonly string[]): (Node | string)[] {
  return chords.flatMap((chord, i) => {
    const keys = chord === '+' ? [chord] : chord.split('+');
    const caps = keys.flatMap((key, k) => (k === 0 ? [make('kbd', {}, key)] : ['+', make('kbd', {}, key)]));
    return i === 0 ? caps : [' or ', ...caps];
  });
}
