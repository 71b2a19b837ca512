import { make, setText } from './dom';
import type { Shortcut, ShortcutGroup } from './shortcut';

/** A line of the help. */
interface HelpLine {
  /** Keys, each as its caps; any of them does it. */
  keys: readonly (readonly string[])[];
  what: string;
}

const kNames: Record<string, string> = {
  ArrowLeft: '←',
  ArrowRight: '→',
  ArrowUp: '↑',
  ArrowDown: '↓',
  Escape: 'Esc',
};

function capsOf(chord: string): string[] {
  const keys = chord === '+' ? [chord] : chord.split('+');
  return keys.map((key) => kNames[key] ?? key);
}

/** Returns lines for shortcuts. Neighbours of one family share a line. */
export function helpLines(shortcuts: readonly Shortcut[]): HelpLine[] {
  const lines: (HelpLine & { family: string | undefined })[] = [];
  for (const { chords, what, family } of shortcuts) {
    const last = lines.at(-1);
    const keys = chords.map(capsOf);
    if (family !== undefined && last?.family === family) last.keys = [...last.keys, ...keys];
    else lines.push({ keys, what: family ?? what, family });
  }
  return lines;
}

/** True if a line has all the words, in its keys, its text or the title of its group; capitals do not matter. */
export function isFound({ keys, what }: HelpLine, title: string, words: string): boolean {
  const text = `${title} ${what} ${keys.map((caps) => caps.join('+')).join(' ')}`.toLowerCase();
  return words.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

interface Section {
  readonly element: HTMLElement;
  readonly title: string;
  readonly rows: readonly { line: HelpLine; elements: readonly HTMLElement[] }[];
}

/** The help page of keys, made from the table by which keys are bound. It can be searched. */
export class Help {
  private readonly field: HTMLInputElement;
  private readonly none: HTMLElement;
  private sections: readonly Section[] = [];

  constructor(private readonly dialog: HTMLDialogElement) {
    this.field = dialog.querySelector<HTMLInputElement>('input[type=search]')!;
    this.none = dialog.querySelector<HTMLElement>('.none')!;
    this.field.addEventListener('input', () => this.search());
    dialog.querySelector('[data-close]')!.addEventListener('click', () => dialog.close());
    dialog.addEventListener('click', (event) => {
      if (event.target === dialog) dialog.close();
    });
  }

  fill(groups: readonly ShortcutGroup[]): void {
    this.sections = groups.map(({ title, intro, shortcuts }) => {
      const rows = helpLines(shortcuts).map((line) => {
        return { line, elements: [make('dt', {}, ...keycaps(line.keys)), make('dd', {}, line.what)] };
      });
      const list = make('dl', {}, ...rows.flatMap(({ elements }) => elements));
      const element = make('section', {}, make('h4', {}, title), ...(intro ? [make('p', {}, intro)] : []), list);
      return { element, title, rows };
    });
    const chapter = (name: string, isIn: (group: ShortcutGroup) => boolean) => {
      const sections = this.sections.filter((_, i) => isIn(groups[i])).map(({ element }) => element);
      return make('section', { className: 'chapter' }, make('h3', {}, name), make('div', { className: 'shortcuts' }, ...sections));
    };
    this.dialog
      .querySelector('.chapters')!
      .replaceChildren(
        chapter('At any time', ({ tools }) => tools === undefined),
        chapter('With a tool in hand', ({ tools }) => tools !== undefined),
      );
  }

  open(): void {
    this.field.value = '';
    this.search();
    this.dialog.showModal();
    // On a phone the field would open the keyboard over the text.
    if (matchMedia('(pointer: fine)').matches) this.field.focus();
    this.dialog.scrollTop = 0;
  }

  private search(): void {
    const words = this.field.value.trim();
    let isAny = false;
    for (const { element, title, rows } of this.sections) {
      const found = rows.filter(({ line }) => isFound(line, title, words));
      for (const row of rows) row.elements.forEach((each) => (each.hidden = !found.includes(row)));
      element.hidden = found.length === 0;
      isAny ||= found.length > 0;
    }
    for (const chapter of this.dialog.querySelectorAll<HTMLElement>('.chapter')) {
      chapter.hidden = chapter.querySelector('.shortcuts > section:not([hidden])') === null;
    }
    setText(this.none, isAny ? '' : `Nothing is called “${words}” here.`);
  }
}

// Keys of one family share what is held with them: "Shift+← → ↑ ↓".
function keycaps(keys: readonly (readonly string[])[]): (Node | string)[] {
  const [first] = keys;
  const held = first.slice(0, -1);
  const areAlike = keys.length > 2 && keys.every((caps) => caps.slice(0, -1).join() === held.join());
  const cap = (key: string) => make('kbd', {}, key);
  const joined = (caps: readonly string[]) => caps.flatMap((key, i) => (i === 0 ? [cap(key)] : ['+', cap(key)]));
  if (!areAlike) return keys.flatMap((caps, i) => (i === 0 ? joined(caps) : [' or ', ...joined(caps)]));
  return [...held.flatMap((key) => [cap(key), '+']), ...keys.flatMap((caps, i) => (i === 0 ? [cap(caps.at(-1)!)] : [' ', cap(caps.at(-1)!)]))];
}
