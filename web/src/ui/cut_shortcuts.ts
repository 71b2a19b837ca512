import type { CutTarget } from '../tools/drawing_plane';
import type { CutMode } from '../tools/drawings/kinds';
import type { KeyedParts, Shortcut, ShortcutGroup } from './shortcut';

function setMode(parts: KeyedParts, chord: string, mode: CutMode, what: string): Shortcut {
  return { chords: [chord], what, button: `[data-mode=${mode}]`, run: () => parts.tools.cut.setMode(mode) };
}

function setTarget(parts: KeyedParts, chord: string, target: CutTarget, what: string): Shortcut {
  return { chords: [chord], what, run: () => parts.tools.cut.setTarget(target) };
}

/** Returns the shortcuts of the tool that cuts. */
export function cutGroups(parts: KeyedParts): ShortcutGroup[] {
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
