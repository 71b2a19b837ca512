import { Scope } from '../gen/kerf/v1/access_service_pb';
import type { Stage } from '../scene/stage';
import type { CutTool } from '../tools/cut_tool';
import type { CutMode } from '../tools/drawings/kinds';
import type { CutTarget } from '../tools/drawing_plane';
import { kCrossFineStep, kCrossStep } from '../tools/keyboard_pointer';
import type { KeyboardPointer } from '../tools/keyboard_pointer';
import { pressVerb } from '../tools/press_verb';
import type { ToolId } from '../tools/tool';
import type { HistoryStep } from './history_controls';
import type { SheetLook } from './sheet_look';
import type { SidePanels } from './side_panels';
import type { SimulationControls } from './simulation_controls';

type KeyedCutTool = Pick<
  CutTool,
  | 'isReady'
  | 'dashes'
  | 'cut'
  | 'escape'
  | 'removeLast'
  | 'again'
  | 'setDashes'
  | 'setMode'
  | 'setTarget'
  | 'stepWeight'
>;

interface Toggled {
  toggle(): void;
}

/** The parts of the viewer that keys act on. */
export interface KeyedParts {
  readonly tools: {
    choose(id: ToolId): void;
    readonly cut: KeyedCutTool;
    readonly grab: { escape(): boolean };
    readonly cutPanel: { askWidth(): void };
    readonly keyboardPointer: Pick<KeyboardPointer, 'move' | 'press' | 'hide'>;
  };
  readonly controls: Pick<SimulationControls, 'togglePause' | 'step' | 'reset'> & {
    readonly speed: Pick<SimulationControls['speed'], 'set' | 'step'>;
  };
  readonly history: { run(step: HistoryStep, isHeld?: boolean): Promise<void> };
  readonly look: Pick<SheetLook, 'toggleWireframe' | 'toggleByPiece' | 'toggleByStrain'>;
  readonly imageMode: { toggle(): Promise<void> };
  readonly shown: { fit(): void };
  readonly theme: { next(): void };
  readonly stage: Pick<Stage, 'orbit' | 'pan' | 'zoom'>;
  readonly statistics: Toggled;
  readonly saveMenu: Toggled;
  readonly svgFiles: { choose(): void };
  readonly panels: Pick<SidePanels, 'toggle' | 'close'>;
  readonly pointing: Toggled;
}

/** One action of keys. */
export interface Shortcut {
  /** Keys for the action, as named by chordOf(); each of them triggers it. */
  readonly chords: readonly string[];
  /** Description of the action for the help. */
  readonly what: string;
  /** CSS selector of the button with the same action; its tip names the key. */
  readonly button?: string;
  /** True if a click of the button runs the shortcut, because the button has no listener of its own. */
  readonly isClicked?: boolean;
  /** The right that the action needs, if any; the choice of a tool asks by itself. */
  readonly needs?: Scope;
  /** True if a held key repeats the action. */
  readonly isRepeated?: boolean;
  /**
   * Runs the action. False: there was nothing to do, so the next meaning of the key is tried.
   * @param isHeld  true for repeats of a held key
   */
  run(isHeld?: boolean): boolean | void;
}

export interface ShortcutGroup {
  readonly title: string;
  /** Text about what can be done without keys. */
  readonly intro?: string;
  /** The tools with which these keys work; undefined: with every tool. */
  readonly tools?: readonly ToolId[];
  readonly shortcuts: readonly Shortcut[];
}

/**
 * Returns the name of a key press: "Ctrl+Shift+Z", "W", "Space", "?". Cmd counts as Ctrl. Shift is left out if the
 * key's character already implies it.
 */
export function chordOf(event: Pick<KeyboardEvent, 'key' | 'ctrlKey' | 'metaKey' | 'shiftKey' | 'altKey'>): string {
  const { key } = event;
  const name = key === ' ' ? 'Space' : key.length === 1 ? key.toUpperCase() : key;
  const isNamedByKey = key.length === 1 && key.toLowerCase() === key.toUpperCase() && key !== ' ';
  const shift = event.shiftKey && !isNamedByKey ? 'Shift+' : '';
  return `${event.ctrlKey || event.metaKey ? 'Ctrl+' : ''}${event.altKey ? 'Alt+' : ''}${shift}${name}`;
}

/** Returns all shortcuts of a chord while `tool` is chosen, those of the tool itself first. */
export function shortcutsFor(groups: readonly ShortcutGroup[], tool: ToolId, chord: string): Shortcut[] {
  const isOwn = (group: ShortcutGroup) => group.tools?.includes(tool);
  const ordered = [...groups.filter(isOwn), ...groups.filter((group) => group.tools === undefined)];
  return ordered.flatMap((group) => group.shortcuts.filter((shortcut) => shortcut.chords.includes(chord)));
}

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
    ],
  };
}

function setMode(parts: KeyedParts, chord: string, mode: CutMode, what: string): Shortcut {
  return { chords: [chord], what, button: `[data-mode=${mode}]`, run: () => parts.tools.cut.setMode(mode) };
}

function setTarget(parts: KeyedParts, chord: string, target: CutTarget, what: string): Shortcut {
  return { chords: [chord], what, run: () => parts.tools.cut.setTarget(target) };
}

function cutGroups(parts: KeyedParts): ShortcutGroup[] {
  const { cut: cutTool, cutPanel } = parts.tools;
  return [
    {
      title: 'Cutting',
      intro: 'Start and end beside the sheet to cut it through.',
      tools: ['cut'],
      shortcuts: [
        { chords: ['Enter'], what: 'Cut', button: '#cut-apply', run: () => cutTool.isReady && void cutTool.cut() },
        { chords: ['Escape'], what: 'Discard the drawing', button: '#cut-cancel', run: () => cutTool.escape() },
        { chords: ['Backspace'], what: 'Remove the last point', run: () => cutTool.removeLast() },
        { chords: ['N'], what: 'Draw the last cut again', button: '#cut-again', run: () => cutTool.again() },
        {
          chords: ['D'],
          what: 'Perforate instead of cutting through',
          button: '#cut-dashed',
          run: () => cutTool.setDashes({ isOn: !cutTool.dashes.isOn }),
        },
        {
          chords: ['T'],
          what: 'Width to remove: the cut takes away a strip of so many millimetres, and whole pieces inside it',
          button: '#cut-width',
          run: () => cutPanel.askWidth(),
        },
        { chords: ['+'], what: 'More weight for the chosen point of a curve', run: () => cutTool.stepWeight(1) },
        { chords: ['-'], what: 'Less weight for that point', run: () => cutTool.stepWeight(-1) },
      ],
    },
    {
      title: 'What is drawn',
      tools: ['cut'],
      shortcuts: [
        setMode(parts, 'B', 'curve', 'Bézier curve of three or four points'),
        setMode(parts, 'I', 'lines', 'Straight lines'),
        setMode(parts, 'L', 'freehand', 'Freehand line'),
        setMode(parts, 'O', 'circle', 'Circle'),
        setMode(parts, 'E', 'ellipse', 'Ellipse'),
        {
          ...setMode(parts, 'S', 'svg', 'SVG file: chosen, or dropped on the sheet, then moved and scaled'),
          run: () => {
            cutTool.setMode('svg');
            parts.svgFiles.choose();
          },
        },
      ],
    },
    {
      title: 'What is cut',
      tools: ['cut'],
      shortcuts: [
        setTarget(parts, '1', 'seen', 'What is seen under the line'),
        setTarget(parts, '2', 'all', 'Every layer'),
        setTarget(parts, '3', 'piece', 'One piece: the one seen where the line first meets the sheet, or one that you choose'),
        setTarget(parts, '4', 'depth', 'What lies between two distances from the camera'),
        setTarget(parts, '5', 'material', 'The material: the line then moves with the sheet'),
      ],
    },
  ];
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
    isRepeated: true,
    run: () => stage.orbit(-right * kTurn, up * kTurn),
  }));
  const shift = kArrows.map(([key, word, right, up]) => ({
    chords: [`Shift+${key}`],
    what: `Move the view ${word}`,
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
      isRepeated: true,
      run: () => keyboardPointer.move(step * right, -step * up),
    }));
  return {
    title: 'A cross in place of the mouse',
    intro: 'Enter presses; the arrows then drag, until Enter lets go.',
    tools: ['cut', 'grab', 'pin'],
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
  return [...always, viewKeys(parts), crossKeys(parts), ...cutGroups(parts), grabGroup(parts)];
}
