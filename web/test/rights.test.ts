import { create } from '@bufbuild/protobuf';
import { readFileSync } from 'node:fs';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { AccessSchema, Scope } from '../src/gen/kerf/v1/access_service_pb';
import { Rights } from '../src/ui/access/rights';
import { shortcutGroups } from '../src/ui/shortcuts';
import type { KeyedParts } from '../src/ui/shortcut';

const kPage = readFileSync(new URL('../index.html', import.meta.url), 'utf8');
const kStyle = readFileSync(new URL('../src/style/side_panels.css', import.meta.url), 'utf8');

describe('Rights', () => {
  const notices: string[] = [];
  const dataset: Record<string, string> = {};
  const groups = [
    { dataset: { needs: 'cut' }, disabled: false },
    { dataset: { needs: 'admin' }, disabled: false },
  ];
  let rights: Rights;
  const given = (scope: Scope, asksForTokens = true) => rights.set(create(AccessSchema, { scope, asksForTokens }));
  const disabled = () => groups.filter((group) => group.disabled).map((group) => group.dataset.needs);

  beforeEach(() => {
    notices.length = 0;
    vi.stubGlobal('document', { documentElement: { dataset }, querySelectorAll: () => groups });
    rights = new Rights({ notify: (kind, text) => void notices.push(`${kind}: ${text}`) });
  });
  afterEach(() => vi.unstubAllGlobals());

  it.each([
    [Scope.VIEW, 'cut admin'],
    [Scope.CUT, 'admin'],
    [Scope.ADMIN, ''],
  ])('with scope %i lack "%s"', (scope, lacks) => {
    given(scope);
    expect([dataset.lacks, disabled().join(' ')]).toEqual([lacks, lacks]);
    expect(rights.may(Scope.CUT)).toBe(!lacks.includes('cut'));
    expect(rights.may(Scope.ADMIN)).toBe(!lacks.includes('admin'));
  });

  it('are all there before the server has answered, and where it asks for no tokens', () => {
    expect(rights.allows(Scope.ADMIN)).toBe(true);
    given(Scope.UNSPECIFIED, false);
    expect([dataset.lacks, rights.allows(Scope.ADMIN), notices]).toEqual(['', true, []]);
  });

  it('say what is lacking', () => {
    given(Scope.VIEW);
    expect([rights.allows(Scope.VIEW), rights.allows(Scope.CUT), rights.allows(Scope.ADMIN)]).toEqual([true, false, false]);
    expect(notices.splice(0)).toEqual([
      'info: You may look only: changes need a token with more rights',
      'info: You may not make or delete sheets: that needs a token with more rights',
    ]);
    rights.set(undefined);
    expect(rights.allows(Scope.CUT)).toBe(false);
    expect(notices).toEqual(['info: Log in first, under Access']);
  });
});

describe('controls', () => {
  /** Tag of the control with this id or other attribute. */
  const tag = (attribute: string) => new RegExp(`<[^>]*${attribute}[^>]*>`).exec(kPage)?.[0] ?? '';

  it.each(['data-tool="cut"', 'data-tool="grab"', 'data-tool="pin"', 'id="pause"', 'id="step"', 'id="reset"', 'id="undo"', 'id="redo"'])(
    'that change a sheet name the right that they need: %s',
    (attribute) => expect(tag(attribute)).toContain('data-needs="cut"'),
  );

  it.each(['id="new-sheet-open"', 'id="play-run"'])('that make sheets name the right that they need: %s', (attribute) =>
    expect(tag(attribute)).toContain('data-needs="admin"'),
  );

  it('of settings and saved states are in groups with a right', () => {
    for (const id of ['gravity', 'wind-on', 'pin-apply', 'material-preset', 'self-contact-on', 'state-form', 'state-list']) {
      const before = kPage.slice(0, kPage.indexOf(`id="${id}"`));
      expect(before.slice(before.lastIndexOf('<fieldset')), id).toMatch(/^<fieldset[^>]*data-needs="cut"/);
    }
  });

  it('have a style for each right that they name, and texts in their place', () => {
    const named = new Set([...kPage.matchAll(/data-(?:needs|lacking)="(\w+)"/g)].map(([, name]) => name));
    expect([...named].sort()).toEqual(['admin', 'cut']);
    for (const name of named) {
      expect(kStyle).toContain(`:root[data-lacks~='${name}'] [data-needs='${name}']`);
      expect(kStyle).toContain(`:root:not([data-lacks~='${name}']) [data-lacking='${name}']`);
      expect(kPage).toContain(`data-lacking="${name}"`);
    }
  });

  it('have keys that need the same right', () => {
    const parts: unknown = new Proxy(() => {}, { get: () => parts, apply: () => undefined });
    const shortcuts = shortcutGroups(parts as KeyedParts, () => {}).flatMap((group) => group.shortcuts);
    const needing = shortcuts.filter(({ needs }) => needs === Scope.CUT).flatMap(({ chords }) => chords);
    expect(needing).toEqual(['Space', '.', '<', '>', '0', 'R', 'Ctrl+Z', 'Ctrl+Shift+Z', 'Ctrl+Y']);
    for (const { button, needs } of shortcuts) {
      if (needs && button !== undefined && button !== '#speed') expect(tag(`id="${button.slice(1)}"`)).toContain('data-needs="cut"');
    }
  });
});
