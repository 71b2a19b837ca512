import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { SvgFiles } from '../src/ui/svg_files';
import type { DrawingContent } from '../src/tools/drawings/drawing_content';
import type { DrawingTools } from '../src/ui/svg_files';
import { fakePage } from './support/fake_page';

describe('SvgFiles', () => {
  const fileOf = (name: string, content: BlobPart) => Object.assign(new Blob([content]), { name }) as File;
  const file = fileOf('sign.svg', '<svg/>');
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
    const notices = {
      notify: (_: string, text: string) => void told.push(text),
      attempt: async <T>(run: () => Promise<T>) => run(),
    };
    const read = async (name: string, content: DrawingContent) => ({ name, content, outline: undefined });
    files = new SvgFiles(tools, notices, () => {}, read);
  });

  afterEach(() => vi.unstubAllGlobals());

  it('are laid on the sheet with the cut tool', async () => {
    await files.take(file);
    expect(laid).toEqual(['sign.svg']);
  });

  it('are refused where they are broken', async () => {
    await files.take(fileOf('sign.svg', '<svg><circ'));
    expect(laid).toEqual([]);
    expect(told).toEqual(['sign.svg is broken: its text ends early or has an error in line 1']);
  });

  it('are laid nowhere while that tool is refused', async () => {
    isReplaying = true;
    await files.take(file);
    expect(laid).toEqual([]);
  });

  it('are SVG or DXF', async () => {
    await files.take(fileOf('plate.dxf', '0\nSECTION\n'));
    await files.take(fileOf('notes.txt', 'words'));
    expect(laid).toEqual(['plate.dxf']);
    expect(told).toEqual(['notes.txt is neither SVG nor DXF']);
  });

  it('are measured without their pictures', async () => {
    await files.take(fileOf('photo.svg', `<svg><image href="data:image/png;base64,${'A'.repeat(600_000)}"/></svg>`));
    await files.take(fileOf('long.svg', `<svg>${' '.repeat(600_000)}</svg>`));
    expect(laid).toEqual(['photo.svg']);
    expect(told).toEqual(['long.svg has 586 KiB; the server accepts drawings of at most 512']);
  });
});
