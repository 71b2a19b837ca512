import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { chordOf, shortcutsFor } from '../src/ui/shortcut';
import type { KeyedParts } from '../src/ui/shortcut';
import { shortcutGroups } from '../src/ui/shortcuts';
import type { ToolId } from '../src/tools/tool';

const kNone = { ctrlKey: false, metaKey: false, shiftKey: false, altKey: false };
const kTools: readonly ToolId[] = ['view', 'cut', 'grab', 'pin'];

// Stands for every part of the viewer, and writes down each call by its path.
function recorder(calls: string[], path = ''): unknown {
  return new Proxy(() => {}, {
    get: (_, name) => recorder(calls, path === '' ? String(name) : `${path}.${String(name)}`),
    apply: () => void calls.push(path),
  });
}

function groupsOf(calls: string[] = []) {
  return shortcutGroups(recorder(calls) as KeyedParts, () => calls.push('help'));
}

describe('chordOf', () => {
  it.each([
    [{ key: 'w' }, 'W'],
    [{ key: 'W', shiftKey: true }, 'Shift+W'],
    [{ key: 'W' }, 'W'],
    [{ key: ' ' }, 'Space'],
    [{ key: '?', shiftKey: true }, '?'],
    [{ key: '+', shiftKey: true }, '+'],
    [{ key: 'z', ctrlKey: true }, 'Ctrl+Z'],
    [{ key: 'z', metaKey: true }, 'Ctrl+Z'],
    [{ key: 'Z', metaKey: true, shiftKey: true }, 'Ctrl+Shift+Z'],
    [{ key: 'z', ctrlKey: true, altKey: true }, 'Ctrl+Alt+Z'],
    [{ key: 'ArrowUp', shiftKey: true }, 'Shift+ArrowUp'],
  ])('names %o %s', (event, chord) => {
    expect(chordOf({ ...kNone, ...event })).toBe(chord);
  });
});

describe('the table of shortcuts', () => {
  it.each(kTools)('has one meaning for each key while the tool is %s', (tool) => {
    const groups = groupsOf();
    const inForce = groups.filter((group) => group.tools === undefined || group.tools.includes(tool));
    const chords = inForce.flatMap((group) => group.shortcuts.flatMap(({ chords }) => chords));
    // Escape and Enter have several meanings, of which the first one that has something to do counts.
    const isShared = (chord: string) => chord === 'Escape' || chord === 'Enter';
    expect(chords.filter((chord, i) => !isShared(chord) && chords.indexOf(chord) !== i)).toEqual([]);
  });

  it('does something with every key', () => {
    for (const { tools, shortcuts } of groupsOf()) {
      for (const { chords } of shortcuts) {
        for (const chord of chords) {
          const calls: string[] = [];
          const [found] = shortcutsFor(groupsOf(calls), tools?.[0] ?? 'view', chord);
          found.run();
          expect(calls.length, chord).toBeGreaterThan(0);
        }
      }
    }
  });

  it('keeps the keys of a tool to the tool', () => {
    expect(shortcutsFor(groupsOf(), 'cut', 'N')).toHaveLength(1);
    expect(shortcutsFor(groupsOf(), 'view', 'N')).toHaveLength(0);
    expect(shortcutsFor(groupsOf(), 'view', 'Ctrl+Alt+Z')).toHaveLength(0);
  });

  it('names buttons that are there', () => {
    const page = readFileSync(new URL('../index.html', import.meta.url), 'utf8');
    for (const { shortcuts } of groupsOf()) {
      for (const { button, what } of shortcuts) {
        if (!button) continue;
        expect(what).not.toBe('');
        const attribute = /^#(.+)$/.test(button)
          ? `id="${button.slice(1)}"`
          : button.replace(/^\[([\w-]+)=([\w-]+)\]$/, '$1="$2"');
        expect(page).toContain(attribute);
      }
    }
  });

  it('holds every letter that the page promises in a tip', () => {
    const page = readFileSync(new URL('../index.html', import.meta.url), 'utf8');
    // Tips get their keys from the table; one that is written into the page could go stale.
    expect(page.match(/title="[^"]*\((?:[A-Z]|Space|Ctrl\+[^)]*)\)"/g)).toBeNull();
  });
});
