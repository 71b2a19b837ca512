import type { Scope } from '../gen/kerf/v1/access_service_pb';
import type { Stage } from '../scene/stage';
import type { CutTool } from '../tools/cut_tool';
import type { KeyboardPointer } from '../tools/keyboard_pointer';
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
    readonly measure: { escape(): boolean };
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
  readonly axes: { toggle(side: string, opposite: string): void };
  readonly statistics: Toggled;
  readonly saveMenu: Toggled;
  readonly viewLink: { copy(): Promise<void> };
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
  /** Text of a line of the help that neighbours with the same text share. */
  readonly family?: string;
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
