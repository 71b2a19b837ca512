import { beforeEach, describe, expect, it } from 'vitest';
import type { App } from '../src/app';
import { SvgFiles } from '../src/ui/svg_files';
import { fakePage } from './support/fake_page';

describe('SvgFiles', () => {
  const file = { name: 'sign.svg', size: 6, type: 'image/svg+xml', text: async () => '<svg/>' } as File;
  let laid: string[];
  let isReplaying: boolean;
  let files: SvgFiles;

  beforeEach(() => {
    fakePage();
    laid = [];
    isReplaying = false;
    const cutTool = { lay: ({ name }: { name: string }) => laid.push(name) > 0 };
    const app = {
      tool: {},
      cutTool,
      choose: () => {
        if (!isReplaying) app.tool = cutTool;
      },
      focusStage: () => {},
      notify: () => {},
    };
    files = new SvgFiles(app as unknown as App);
  });

  it('are laid on the sheet with the cut tool', async () => {
    await files.take(file);
    expect(laid).toEqual(['sign.svg']);
  });

  it('are laid nowhere while that tool is refused', async () => {
    isReplaying = true;
    await files.take(file);
    expect(laid).toEqual([]);
  });
});
