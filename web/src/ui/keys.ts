import type { ToolId } from '../tools/tool';
import type { Rights } from './access/rights';
import { element } from './dom';
import { Help } from './help';
import { chordOf, shortcutsFor } from './shortcut';
import type { KeyedParts, Shortcut } from './shortcut';
import { shortcutGroups } from './shortcuts';

/** The parts of the viewer on which keys act, and those that decide the meaning of keys. */
export type KeyBindingParts = KeyedParts & {
  readonly stage: { focus(): void };
  readonly tools: { readonly tool: { readonly id: ToolId } };
  /** Handles the chord for a shown recording; false if it has no meaning there. */
  readonly replayBar: { key(chord: string): boolean };
  readonly rights: Pick<Rights, 'allows'>;
};

// Adds the key to the button's tip, and for screen readers.
function annotate({ button, chords, isClicked, run }: Shortcut): void {
  const target = button && document.querySelector<HTMLElement>(button);
  if (!target) return;
  const tip = target.closest<HTMLElement>('[title]');
  if (tip) tip.title += ` (${chords[0]})`;
  target.setAttribute('aria-keyshortcuts', chords.map((chord) => chord.replace('Ctrl', 'Control')).join(' '));
  if (isClicked) target.addEventListener('click', () => run());
}

// True if the focused control needs the key: typing for lists and fields, Space and Enter for buttons and boxes, arrows
// for sliders and choices.
function isForControl({ target, key }: KeyboardEvent): boolean {
  const control = target as HTMLElement;
  // A field of a dialog that was closed keeps the focus until the next animation frame.
  if (control.closest('dialog:not([open])')) return false;
  if (control.closest('select, textarea, input:not([type=checkbox], [type=radio], [type=range])')) return true;
  if (control.closest('button, summary, input') && (key === ' ' || key === 'Enter')) return true;
  return control.closest('[role=radio], input') !== null && key.startsWith('Arrow');
}

/** Binds keys, and the buttons with the same actions. */
export function bindKeys(parts: KeyBindingParts): void {
  const help = new Help(element<HTMLDialogElement>('help'));
  const groups = shortcutGroups(parts, () => help.open());
  help.fill(groups);
  for (const { shortcuts } of groups) shortcuts.forEach(annotate);

  // Moves the focus from a clicked button to the canvas; otherwise Space would press the button again instead of
  // pausing. Buttons reached with the Tab key (a click with detail 0) and open menus keep the focus.
  addEventListener('click', (event) => {
    const button = (event.target as HTMLElement).closest('.card button');
    if (event.detail > 0 && button && !button.matches('[aria-haspopup][aria-expanded=true]')) parts.stage.focus();
  });

  addEventListener('keydown', (event) => {
    if (event.defaultPrevented || document.querySelector('dialog[open]') || isForControl(event)) return;
    // While a recording is shown, keys act on it in place of the live sheet.
    if (parts.replayBar.key(chordOf(event))) {
      event.preventDefault();
      return;
    }
    for (const shortcut of shortcutsFor(groups, parts.tools.tool.id, chordOf(event))) {
      // A held key acts once, unless the shortcut is repeated.
      if (event.repeat && !shortcut.isRepeated) event.preventDefault();
      else if (shortcut.needs && !parts.rights.allows(shortcut.needs)) event.preventDefault();
      else if (shortcut.run(event.repeat) !== false) event.preventDefault();
      if (event.defaultPrevented) return;
    }
  });
}
