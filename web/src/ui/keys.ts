import type { App } from '../app';
import type { CutMode, CutTool } from '../tools/cut_tool';
import type { CutTarget } from '../tools/drawing_plane';
import { element } from './dom';
import { historyStep } from './history_controls';

/** Keys and the buttons that do the same. */
export function bindKeys(app: App): void {
  const help = element<HTMLDialogElement>('help');
  const openHelp = () => {
    help.showModal();
    // The focus is on its last line.
    help.scrollTop = 0;
  };
  const actions: Record<string, () => void> = {
    v: () => app.choose('view'),
    c: () => app.choose('cut'),
    g: () => app.choose('grab'),
    p: () => app.choose('pin'),
    b: () => setCutMode('curve'),
    i: () => setCutMode('lines'),
    l: () => setCutMode('freehand'),
    o: () => setCutMode('circle'),
    e: () => setCutMode('ellipse'),
    s: () => {
      setCutMode('svg');
      whenCutting(() => app.svgFiles.choose());
    },
    d: () => whenCutting((tool) => tool.setDashes({ isOn: !tool.dashes.isOn })),
    n: () => whenCutting((tool) => tool.again()),
    t: () => whenCutting(() => app.cutPanel.askWidth()),
    1: () => setCutTarget('seen'),
    2: () => setCutTarget('all'),
    3: () => setCutTarget('piece'),
    4: () => setCutTarget('depth'),
    5: () => setCutTarget('material'),
    ' ': () => void app.controls.togglePause(),
    '.': () => void app.controls.step(),
    r: () => void app.controls.reset(),
    w: () => app.toggleWireframe(),
    k: () => app.toggleByPiece(),
    x: () => app.toggleByStrain(),
    f: () => app.fit(),
    '?': openHelp,
  };
  const whenCutting = (act: (tool: CutTool) => void) => {
    if (app.tool === app.cutTool) act(app.cutTool);
  };
  const setCutMode = (mode: CutMode) => whenCutting((tool) => tool.setMode(mode));
  const setCutTarget = (target: CutTarget) => whenCutting((tool) => tool.setTarget(target));

  element('undo').addEventListener('click', () => void app.history.run('undo'));
  element('redo').addEventListener('click', () => void app.history.run('redo'));
  element('wireframe').addEventListener('click', actions.w);
  element('by-piece').addEventListener('click', actions.k);
  element('by-strain').addEventListener('click', actions.x);
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
    // Typing in a list searches it and in a field fills it; sliders only want arrows.
    if (target.closest('select, input[type=number]')) return;
    if (target.closest('button, input[type=checkbox]') && (event.key === ' ' || event.key === 'Enter')) return;
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
