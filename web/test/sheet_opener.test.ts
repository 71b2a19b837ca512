import { beforeEach, describe, expect, it, vi } from 'vitest';
import { SheetOpener } from '../src/ui/sheet_opener';
import type { FollowingParts } from '../src/ui/sheet_opener';

describe('SheetOpener', () => {
  let calls: string[];
  let live: { sheetName: string; isWatched: boolean };
  let replayBar: { hasFile: boolean };
  let opener: SheetOpener;

  // A part that writes down each call, by the part's name.
  const part = <T extends object>(name: string, state: T = {} as T): T =>
    new Proxy(state, {
      get: (target, key) =>
        key in target ? target[key as keyof T] : (...args: unknown[]) => void calls.push([name, key, ...args].join(' ')),
    });

  beforeEach(() => {
    vi.stubGlobal('document', { querySelectorAll: () => [] });
    calls = [];
    live = { sheetName: 'sheets/a', isWatched: true };
    replayBar = { hasFile: false };
    opener = new SheetOpener({
      live: part('live', live),
      shown: part('shown'),
      tools: part('tools', { tool: part('tool') }),
      recording: part('recording'),
      imageMode: part('imageMode'),
      replayBar: part('replayBar', replayBar),
      panels: part('panels', { open: 'physics' }),
      connection: part('connection'),
      people: part('people'),
    } as unknown as FollowingParts);
  });

  const kLetGo = ['tool leave', 'recording stop', 'live close', 'people clear', 'imageMode close', 'shown clear'];

  it('lets the last sheet go before it opens the next, and ends a recording', () => {
    opener.open('sheets/b');
    expect(calls).toEqual([...kLetGo, 'replayBar leave', 'live open sheets/b', 'imageMode follow', 'live refresh']);
  });

  it('keeps the recording that is shown or read where a sheet is only offered or gone', () => {
    replayBar.hasFile = true;
    opener.offer('sheets/b');
    expect(live.sheetName).toBe('sheets/b');
    opener.close();
    expect([live.sheetName, calls]).toEqual(['', []]);
  });

  it('takes the last sheet out of the picture where none is left', () => {
    opener.close();
    expect([live.sheetName, calls]).toEqual(['', [...kLetGo, 'imageMode clear', 'shown hide']]);
  });

  it('shows a recording with the view tool, without the panels of the live sheet, whose name it keeps', () => {
    opener.showReplay({} as never);
    expect(calls.slice(0, kLetGo.length)).toEqual(kLetGo);
    expect(calls).toContain('tools choose view');
    expect(calls).toContain('panels close');
    expect(calls.at(-1)).toBe('connection show replay ');
    expect(live.sheetName).toBe('sheets/a');
  });

  it('returns from a recording to the live sheet, unless that was never left', () => {
    opener.leaveReplay();
    expect(calls).toEqual([]);
    live.isWatched = false;
    opener.leaveReplay();
    expect(calls).toContain('live open sheets/a');
    live.sheetName = '';
    opener.leaveReplay();
    expect(calls.at(-1)).toBe('shown hide');
  });
});
