import type { App } from '../app';
import { element } from './dom';
import { historyStep } from './history_controls';

/** Keys and the buttons that do the same. */
export function bindKeys(app: App): void {
  const help = element<HTMLDialogElement>('help');
  const openHelp = () => help.showModal();
  const actions: Record<string, () => void> = {
    v: () => app.choose('view'),
    c: () => app.choose('cut'),
    g: () => app.choose('grab'),
    p: () => app.choose('pin'),
    b: () => setCutMode('bezier'),
    l: () => setCutMode('freehand'),
    ' ': () => void app.controls.togglePause(),
    '.': () => void app.controls.step(),
    r: () => void app.controls.reset(),
    w: () => app.toggleWireframe(),
    f: () => app.fit(),
    '?': openHelp,
  };
  const setCutMode = (mode: 'bezier' | 'freehand') => {
    if (app.tool === app.cutTool) app.cutTool.setMode(mode);
  };

  element('undo').addEventListener('click', () => void app.history.run('undo'));
  element('redo').addEventListener('click', () => void app.history.run('redo'));
  element('wireframe').addEventListener('click', actions.w);
  element('fit').addEventListener('click', actions.f);
  element('help-open').addEventListener('click', openHelp);
  help.addEventListener('click', (event) => {
    if (event.target === help) help.close();
  });

  // A button that was clicked would keep the keyboard: Space would press it again rather than pause. Buttons reached
  // with the Tab key (a click of detail 0) keep it.
  addEventListener('click', (event) => {
    if (event.detail > 0 && (event.target as HTMLElement).closest('.card button')) app.focusStage();
  });

  addEventListener('keydown', (event) => {
    const step = help.open ? undefined : historyStep(event);
    if (step) {
      event.preventDefault();
      void app.history.run(step);
      return;
    }
    if (event.ctrlKey || event.metaKey || event.altKey || help.open) return;
    const target = event.target as HTMLElement;
    // Typing in the list of sheets searches it; the gravity slider only wants arrows.
    if (target.closest('select')) return;
    if (target.closest('button') && (event.key === ' ' || event.key === 'Enter')) return;
    if (app.tool.key(event.key)) {
      event.preventDefault();
      return;
    }
    const action = actions[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    // A held key steps on; everything else happens once.
    if (!event.repeat || event.key === '.') action();
  });
}
