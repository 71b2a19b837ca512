import { Scope } from '../gen/kerf/v1/access_service_pb';
import { kCrossFineStep, kCrossStep } from '../tools/keyboard_pointer';
import { pressVerb } from '../tools/press_verb';
import type { ToolId } from '../tools/tool';
import { cutGroups } from './cut_shortcuts';
import type { KeyedParts, Shortcut, ShortcutGroup } from './shortcut';

function chooseTool(parts: KeyedParts, chord: string, tool: ToolId, what: string): Shortcut {
  return { chords: [chord], what, button: `[data-tool=${tool}]`, run: () => parts.tools.choose(tool) };
}

function toolGroup(parts: KeyedParts): ShortcutGroup {
  const press = pressVerb().toLowerCase();
  return {
    title: 'Tools',
    intro: 'A drag that the tool does not use moves the view.',
    shortcuts: [
      chooseTool(parts, 'V', 'view', 'View: drag to orbit, right-drag or two fingers to move, wheel or pinch to zoom'),
      chooseTool(parts, 'C', 'cut', 'Cut: draw on the picture and adjust; what is seen under the line is cut'),
      chooseTool(parts, 'G', 'grab', 'Grab: drag a vertex, and the sheet follows on a spring'),
      chooseTool(parts, 'P', 'pin', `Pin: ${press} a vertex to hold it where it is, ${press} again to let go`),
      chooseTool(parts, 'Shift+M', 'measure', `Measure: ${press} two points for their distance, and the area of a piece`),
    ],
  };
}

function simulationGroup(parts: KeyedParts): ShortcutGroup {
  const { controls, history } = parts;
  return {
    title: 'Simulation',
    shortcuts: [
      { chords: ['Space'], what: 'Pause or resume', button: '#pause', isClicked: true, run: () => controls.togglePause() },
      {
        chords: ['.'],
        what: 'Pause and advance by one tick',
        button: '#step',
        isClicked: true,
        isRepeated: true,
        run: () => void controls.step(),
      },
      {
        chords: ['<'],
        what: 'Half as fast: slow motion',
        button: '#speed',
        isRepeated: true,
        run: () => controls.speed.step(-1),
      },
      { chords: ['>'], what: 'Twice as fast', isRepeated: true, run: () => controls.speed.step(1) },
      { chords: ['0'], what: 'Real time: speed 1', run: () => controls.speed.set(1) },
      { chords: ['R'], what: 'Play the scene from its beginning', button: '#reset', isClicked: true, run: () => void controls.reset() },
      {
        chords: ['Ctrl+Z'],
        what: 'Undo the last cut or reset',
        button: '#undo',
        isClicked: true,
        isRepeated: true,
        run: (isHeld) => void history.run('undo', isHeld),
      },
      {
        chords: ['Ctrl+Shift+Z', 'Ctrl+Y'],
        what: 'Redo what was undone last',
        button: '#redo',
        isClicked: true,
        isRepeated: true,
        run: (isHeld) => void history.run('redo', isHeld),
      },
    ],
  };
}

function viewGroup(parts: KeyedParts, openHelp: () => void): ShortcutGroup {
  return {
    title: 'What is shown',
    shortcuts: [
      { chords: ['W'], what: 'Wireframe', button: '#wireframe', isClicked: true, run: () => parts.look.toggleWireframe() },
      {
        chords: ['K'],
        what: 'A colour for each piece, kept until that piece is cut',
        button: '#by-piece',
        isClicked: true,
        run: () => parts.look.toggleByPiece(),
      },
      { chords: ['X'], what: 'Colours by strain', button: '#by-strain', isClicked: true, run: () => parts.look.toggleByStrain() },
      {
        chords: ['Q'],
        what: 'Show pictures drawn by the server instead of the mesh, or the mesh again',
        button: '#image-mode',
        isClicked: true,
        run: () => void parts.imageMode.toggle(),
      },
      { chords: ['7'], what: 'From above, then from below', run: () => parts.axes.toggle('+z', '-z') },
      { chords: ['8'], what: 'From the front (−y), then from the back', run: () => parts.axes.toggle('-y', '+y') },
      { chords: ['9'], what: 'From the right (+x), then from the left', run: () => parts.axes.toggle('+x', '-x') },
      { chords: ['F'], what: 'Show the whole sheet', button: '#fit', isClicked: true, run: () => parts.shown.fit() },
      {
        chords: ['H'],
        what: 'Light, dark, or the system’s theme',
        button: '#theme',
        isClicked: true,
        run: () => parts.theme.next(),
      },
      { chords: ['?'], what: 'This page', button: '#help-open', isClicked: true, run: openHelp },
    ],
  };
}

function streamGroup(parts: KeyedParts): ShortcutGroup {
  return {
    title: 'Stream and files',
    intro: 'While a recording plays: Space plays or pauses, . and , go one frame forward or back, Escape closes it.',
    shortcuts: [
      {
        chords: ['U'],
        what: 'Statistics of the last seconds: frames, bytes, ages, ticks',
        button: '#statistics-toggle',
        isClicked: true,
        run: () => parts.statistics.toggle(),
      },
      {
        chords: ['Ctrl+S'],
        what: 'Save a picture, a mesh or a recording, or play one',
        button: '#save-open',
        isClicked: true,
        run: () => parts.saveMenu.toggle(),
      },
      {
        chords: ['Shift+L'],
        what: 'Copy a link to this view: sheet, camera and colours',
        button: '#save-link',
        isClicked: true,
        run: () => void parts.viewLink.copy(),
      },
    ],
  };
}

function panelGroup(parts: KeyedParts): ShortcutGroup {
  const panel = (chord: string, id: string, what: string): Shortcut => ({
    chords: [chord],
    what,
    button: `[data-panel=${id}]`,
    isClicked: true,
    run: () => parts.panels.toggle(id),
  });
  return {
    title: 'Panels',
    shortcuts: [
      panel('A', 'sheets', 'All sheets: open, delete, create new ones'),
      panel('M', 'physics', 'Gravity, wind, pins and material'),
      panel('J', 'pieces', 'All pieces with their sizes'),
      panel('Shift+C', 'cuts', 'All cuts: show one on the sheet, undo back to one'),
      panel('Shift+G', 'plots', 'Plots over time: energy, forces, a point'),
      panel('Y', 'states', 'Saved states: save one, go back to one'),
      panel('Shift+P', 'people', 'Who watches the sheet, and what they did'),
      {
        chords: ['Z'],
        what: 'Show others where you point, or stop',
        button: '#pointing',
        isClicked: true,
        run: () => parts.pointing.toggle(),
      },
      { chords: ['Escape'], what: 'Close the panel', run: () => parts.panels.close() },
    ],
  };
}

function measureGroup(parts: KeyedParts): ShortcutGroup {
  return {
    title: 'Measuring',
    tools: ['measure'],
    shortcuts: [{ chords: ['Escape'], what: 'Remove the points', run: () => parts.tools.measure.escape() }],
  };
}

function grabGroup(parts: KeyedParts): ShortcutGroup {
  return {
    title: 'Grabbing',
    tools: ['grab'],
    shortcuts: [{ chords: ['Escape'], what: 'Let go', run: () => parts.tools.grab.escape() }],
  };
}

// Angle (radians) and factor by which one key press turns the view and moves it nearer.
const kTurn = Math.PI / 36;
const kNearer = 1.15;
// CSS pixels by which one key press shifts the view.
const kShift = 40;

const kArrows: readonly [key: string, word: string, right: number, up: number][] = [
  ['ArrowLeft', 'left', -1, 0],
  ['ArrowRight', 'right', 1, 0],
  ['ArrowUp', 'up', 0, 1],
  ['ArrowDown', 'down', 0, -1],
];

function viewKeys(parts: KeyedParts): ShortcutGroup {
  const { stage } = parts;
  const turn = kArrows.map(([key, word, right, up]) => ({
    chords: [key],
    what: `Turn the view ${word}`,
    family: 'Turn the view',
    isRepeated: true,
    run: () => stage.orbit(-right * kTurn, up * kTurn),
  }));
  const shift = kArrows.map(([key, word, right, up]) => ({
    chords: [`Shift+${key}`],
    what: `Move the view ${word}`,
    family: 'Move the view',
    isRepeated: true,
    run: () => stage.pan(right * kShift, up * kShift),
  }));
  return {
    title: 'Viewing',
    tools: ['view'],
    shortcuts: [
      ...turn,
      ...shift,
      { chords: ['+'], what: 'Zoom in', isRepeated: true, run: () => stage.zoom(kNearer) },
      { chords: ['-'], what: 'Zoom out', isRepeated: true, run: () => stage.zoom(1 / kNearer) },
    ],
  };
}

function crossKeys(parts: KeyedParts): ShortcutGroup {
  const { keyboardPointer } = parts.tools;
  const moves = ([prefix, step, how]: [string, number, string]) =>
    kArrows.map(([key, word, right, up]) => ({
      chords: [`${prefix}${key}`],
      what: `Move the cross ${word}${how}`,
      family: `Move the cross${how}`,
      isRepeated: true,
      run: () => keyboardPointer.move(step * right, -step * up),
    }));
  return {
    title: 'A cross in place of the mouse',
    intro: 'Enter presses; the arrows then drag, until Enter lets go.',
    tools: ['cut', 'grab', 'pin', 'measure', 'pick'],
    shortcuts: [
      { chords: ['Enter'], what: 'Set a point, press, or let go at the cross', run: () => keyboardPointer.press() },
      { chords: ['Escape'], what: 'Hide the cross', run: () => keyboardPointer.hide() },
      ...moves(['', kCrossStep, '']),
      ...moves(['Shift+', kCrossFineStep, ', a little']),
    ],
  };
}

function needing(needs: Scope, group: ShortcutGroup): ShortcutGroup {
  return { ...group, shortcuts: group.shortcuts.map((each) => ({ ...each, needs })) };
}

/** Returns all shortcuts, for keys.ts and for the help. If two groups have the same key, the first one counts. */
export function shortcutGroups(parts: KeyedParts, openHelp: () => void): ShortcutGroup[] {
  const simulation = needing(Scope.CUT, simulationGroup(parts));
  const always = [toolGroup(parts), simulation, viewGroup(parts, openHelp), panelGroup(parts), streamGroup(parts)];
  return [...always, viewKeys(parts), crossKeys(parts), ...cutGroups(parts), grabGroup(parts), measureGroup(parts)];
}
