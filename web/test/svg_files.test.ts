import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { SvgFiles } from '../src/ui/svg_files';
import type { DrawingTools } from '../src/ui/svg_files';
import { fakePage } from './support/fake_page';

describe('SvgFiles', () => {
  const file = { name: 'sign.svg', size: 6, type: 'image/svg+xml', text: async () => '<svg/>' } as File;
  let laid: string[];
  let told: string[];
  let isReplaying: boolean;
  let files: SvgFiles;

  beforeEach(() => {
    fakePage();
    const parseFromString = (text: string) => ({
      querySelector: () => (text.endsWith('>') ? null : { textContent: 'error on line 1' }),
      documentElement: { localName: 'svg' },
    });
    vi.stubGlobal('DOMParser', class { parseFromString = parseFromString; });
    laid = [];
    told = [];
    isReplaying = false;
    const cut = { lay: ({ name }: { name: string }) => laid.push(name) > 0 };
    const tools: DrawingTools & { tool: object } = {
      tool: {},
      cut,
      choose: () => {
        if (!isReplaying) tools.tool = cut;
      },
    };
    const notices = { notify: (_: string, text: string) => void told.push(text) };
    files = new SvgFiles(tools, notices, () => {});
  });

  afterEach(() => vi.unstubAllGlobals());

  it('are laid on the sheet with the cut tool', async () => {
    await files.take(file);
    expect(laid).toEqual(['sign.svg']);
  });

  it('are refused where they are broken', async () => {
    await files.take({ ...file, text: async () => '<svg><circ' } as File);
    expect(laid).toEqual([]);
    expect(told).toEqual(['sign.svg is broken: its text ends early or has an error in line 1']);
  });

  it('are laid nowhere while that tool is refused', async () => {
    isReplaying = true;
    await files.take(file);
    expect(laid).toEqual([]);
  });
});
