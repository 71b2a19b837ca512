import { beforeEach, describe, expect, it, vi } from 'vitest';
import { ConnectionChip } from '../src/ui/connection_chip';
import type { ConnectedParts } from '../src/ui/connection_chip';

describe('ConnectionChip', () => {
  let parts: { -readonly [Part in keyof ConnectedParts]: ConnectedParts[Part] };
  let chip: ConnectionChip;
  const text = { textContent: '' };
  const page = {
    connection: { dataset: { state: '' }, querySelector: () => text },
    'connection-detail': { hidden: true, textContent: '' },
  };
  const seen = () => [page.connection.dataset.state, text.textContent, page['connection-detail'].textContent];

  beforeEach(() => {
    vi.stubGlobal('document', { getElementById: (id: keyof typeof page) => page[id] });
    parts = {
      live: { watch: { state: 'live', detail: '' } },
      imageMode: { trouble: undefined },
      replayBar: { isOpen: false },
      session: { isOut: false },
    };
    chip = new ConnectionChip(parts);
    chip.show('connecting', '');
  });

  it('shows the trouble with pictures only where the connection of the mesh is well', () => {
    chip.update();
    expect(seen()).toEqual(['live', 'Live', '']);
    parts.imageMode = { trouble: { state: 'lost', detail: 'No pictures' } };
    chip.update();
    expect(seen()).toEqual(['lost', 'Connection lost', 'No pictures']);
    parts.live = { watch: { state: 'ended', detail: 'The sheet is gone' } };
    chip.update();
    expect(seen()).toEqual(['ended', 'Ended', 'The sheet is gone']);
  });

  it('stays as it is without a live sheet', () => {
    parts.live = { watch: undefined };
    chip.update();
    expect(seen()[0]).toBe('connecting');
  });

  it('shows that the user is logged out, with a sheet and without', () => {
    parts.session = { isOut: true };
    chip.update();
    expect(seen()).toEqual(['out', 'Logged out', 'log in to continue']);
    parts.session = { isOut: false };
    chip.update();
    expect(seen()).toEqual(['live', 'Live', '']);
    parts.live = { watch: undefined };
    parts.session = { isOut: true };
    chip.update();
    expect(seen()[0]).toBe('out');
  });

  it('shows nothing of the server beside a recording', () => {
    parts.replayBar = { isOpen: true };
    chip.show('replay', '');
    chip.show('lost', 'no connection');
    chip.update();
    expect(seen()).toEqual(['replay', 'Playing a recording', '']);
  });
});
