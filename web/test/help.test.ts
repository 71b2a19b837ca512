import { describe, expect, it } from 'vitest';
import { helpLines, isFound } from '../src/ui/help';
import { shortcutGroups } from '../src/ui/shortcuts';
import type { KeyedParts } from '../src/ui/shortcut';

const run = () => {};

describe('helpLines', () => {
  it('joins neighbours of one family, and names arrows by arrows', () => {
    const lines = helpLines([
      { chords: ['ArrowLeft'], what: 'Turn left', family: 'Turn', run },
      { chords: ['ArrowRight'], what: 'Turn right', family: 'Turn', run },
      { chords: ['Shift+ArrowUp'], what: 'Move up', family: 'Move', run },
      { chords: ['+'], what: 'Zoom in', run },
      { chords: ['Ctrl+Shift+Z', 'Ctrl+Y'], what: 'Redo', run },
    ]);
    expect(lines.map(({ keys, what }) => [what, keys])).toEqual([
      ['Turn', [['←'], ['→']]],
      ['Move', [['Shift', '↑']]],
      ['Zoom in', [['+']]],
      ['Redo', [['Ctrl', 'Shift', 'Z'], ['Ctrl', 'Y']]],
    ]);
  });

  it('has a line for every key of the viewer', () => {
    const parts = new Proxy({}, { get: () => parts }) as KeyedParts;
    for (const { shortcuts } of shortcutGroups(parts, run)) {
      const keys = helpLines(shortcuts).flatMap((line) => line.keys);
      expect(keys.length).toBe(shortcuts.flatMap(({ chords }) => chords).length);
    }
  });
});

describe('isFound', () => {
  const line = { keys: [['Ctrl', 'Z']], what: 'Undo the last cut or reset' };

  it.each(['', 'undo', 'UNDO reset', 'ctrl+z', 'simulation cut'])('by "%s"', (words) => {
    expect(isFound(line, 'Simulation', words)).toBe(true);
  });

  it.each(['redo', 'undo x'])('not by "%s"', (words) => {
    expect(isFound(line, 'Simulation', words)).toBe(false);
  });
});
