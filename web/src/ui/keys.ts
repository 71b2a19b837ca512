import type { App } from '../app';
import { element } from './dom';
import { Help } from './help';
import { chordOf, shortcutGroups, shortcutsFor } from './shortcuts';
import type { Shortcut } from './shortcuts';

// A tip names the key, and so does what screen readers are told.
function annotate({ button, chords, isClicked, run }: Shortcut): void {
  const target = button && document.querySelector<HTMLElement>(button);
  if (!target) return;
  const tip = target.closest<HTMLElement>('[title]');
  if (tip) tip.title += ` (${chords[0]})`;
  target.setAttribute('aria-keyshortcuts', chords.map((chord) => chord.replace('Ctrl', 'Control')).join(' '));
  if (isClicked) target.addEventListener('click', () => run());
}

// Typing in a list searches it and in a field fills it; a button and a box are pressed by Space and Enter, and sliders
// and choices are moved by arrows.
function isForControl({ target, key }: KeyboardEvent): boolean {
  const control = target as HTMLElement;
  if (control.closest('select, textarea, input:not([type=checkbox], [type=radio], [type=range])')) return true;
  if (control.closest('button, summary, input') && (key === ' ' || key === 'Enter')) return true;
  return control.closest('[role=radio], input') !== null && key.startsWith('Arrow');
}

/** Keys and the buttons that do the same. */
export function bindKeys(app: App): void {
  const help = new Help(element<HTMLDialogElement>('help'));
  const groups = shortcutGroups(app, () => help.open());
  help.fill(groups);
  for (const { shortcuts } of groups) shortcuts.forEach(annotate);

  // A button that was clicked would keep the keyboard: Space would press it again rather than pause. Buttons reached
  // with the Tab key (a click of detail 0) keep it, and a menu that was opened has it.
  addEventListener('click', (event) => {
    const button = (event.target as HTMLElement).closest('.card button');
    if (event.detail > 0 && button && !button.matches('[aria-haspopup][aria-expanded=true]')) app.focusStage();
  });

  addEventListener('keydown', (event) => {
    if (event.defaultPrevented || document.querySelector('dialog[open]') || isForControl(event)) return;
    // Of a recording that is played, in place of the live sheet.
    if (app.replayBar.key(chordOf(event))) {
      event.preventDefault();
      return;
    }
    for (const shortcut of shortcutsFor(groups, app.tool.id, chordOf(event))) {
      // A held key does most things once.
      if (event.repeat && !shortcut.isRepeated) event.preventDefault();
      else if (shortcut.run(event.repeat) !== false) event.preventDefault();
      if (event.defaultPrevented) return;
    }
  });
}
