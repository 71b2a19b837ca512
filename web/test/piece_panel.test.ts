import { create } from '@bufbuild/protobuf';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { ApiError } from '../src/api';
import type { call } from '../src/api';
import { ListPiecesResponseSchema } from '../src/gen/kerf/v1/cuts_pb';
import { PiecePanel } from '../src/ui/piece_panel';

// The part of an element that a list uses. An element that leaves the tree, if only to come back, loses the keyboard.
class FakeElement extends EventTarget {
  static active: FakeElement | null = null;
  readonly style = {};
  children: FakeElement[] = [];
  parent: FakeElement | undefined;
  hidden = true;
  private text = '';

  get textContent(): string {
    return this.text + this.children.map(({ textContent }) => textContent).join(' ');
  }

  set textContent(text: string) {
    this.text = text;
  }

  setAttribute(): void {}

  append(...children: (FakeElement | string)[]): void {
    for (const child of children) {
      if (typeof child === 'string') this.text += child;
      else this.insertBefore(child, null);
    }
  }

  insertBefore(child: FakeElement, next: FakeElement | null): void {
    child.remove();
    this.children.splice(next ? this.children.indexOf(next) : this.children.length, 0, child);
    child.parent = this;
  }

  remove(): void {
    if (this.contains(FakeElement.active)) FakeElement.active = null;
    this.parent?.children.splice(this.parent.children.indexOf(this), 1);
    this.parent = undefined;
  }

  contains(other: FakeElement | null): boolean {
    return other === this || this.children.some((child) => child.contains(other));
  }

  focus(): void {
    FakeElement.active = this;
    this.dispatchEvent(new Event('focus'));
  }
}

describe('PiecePanel', () => {
  let page: Record<string, FakeElement>;
  let answer: () => Promise<unknown>;
  let numAsked: number;
  let panel: PiecePanel;
  const viewer = {
    sheetName: 'sheets/a',
    topologyVersion: 1,
    surface: {},
    highlight: vi.fn(),
    centre: vi.fn(),
  };
  const send = (() => {
    numAsked += 1;
    return answer();
  }) as unknown as typeof call;

  // Pieces as [id, label, area].
  const listed = (...pieces: [id: bigint, label: number, areaM2: number][]) => {
    const response = create(ListPiecesResponseSchema, {
      topologyVersion: viewer.topologyVersion,
      pieces: pieces.map(([id, label, areaM2]) => ({ id, label, areaM2, massKg: areaM2 })),
    });
    answer = () => Promise.resolve(response);
  };
  const rows = () => page['piece-list'].children.map(({ children }) => children[0]);
  const names = () => rows().map(({ textContent }) => /Piece \d+/.exec(textContent)![0]);
  const settled = () => vi.advanceTimersByTimeAsync(0);

  beforeEach(() => {
    vi.useFakeTimers();
    FakeElement.active = null;
    page = {};
    numAsked = 0;
    viewer.topologyVersion = 1;
    viewer.highlight.mockClear();
    vi.stubGlobal('document', {
      getElementById: (id: string) => (page[id] ??= new FakeElement()),
      createElement: () => new FakeElement(),
      get activeElement() {
        return FakeElement.active;
      },
    });
    panel = new PiecePanel(viewer, viewer, send);
  });
  afterEach(() => {
    vi.unstubAllGlobals();
    vi.useRealTimers();
  });

  it('lists pieces, the largest first, once for each cut', async () => {
    listed([1n, 0, 0.2], [2n, 1, 0.8]);
    panel.opened();
    await settled();
    panel.update();
    expect([names(), numAsked]).toEqual([['Piece 2', 'Piece 1'], 1]);
    expect(rows()[0].textContent).toContain('8,000 cm²');
  });

  it('asks again where versions begin again, though the version is the same', async () => {
    listed([1n, 0, 1]);
    panel.opened();
    await settled();
    viewer.surface = {};
    listed([3n, 0, 1]);
    panel.update();
    await settled();
    expect([numAsked, names()]).toEqual([2, ['Piece 3']]);
  });

  it('asks again where a cut came between two pages, though no frame comes', async () => {
    const page = (topologyVersion: number, nextPageToken: string) =>
      Promise.resolve(create(ListPiecesResponseSchema, { topologyVersion, nextPageToken }));
    const torn = [page(1, '1000'), page(2, '')];
    answer = () => {
      const next = torn.shift()!;
      if (torn.length === 0) listed([1n, 0, 1]);
      return next;
    };
    panel.opened();
    await settled();
    expect([numAsked, names()]).toEqual([3, ['Piece 1']]);
  });

  it('says what went wrong, and asks again once a second, though no frame comes', async () => {
    answer = () => Promise.reject(new ApiError('UNAVAILABLE', 'no server'));
    panel.opened();
    for (let i = 0; i < 60; ++i) {
      await vi.advanceTimersByTimeAsync(16);
      panel.update();
    }
    expect([numAsked, page['piece-error'].hidden]).toEqual([1, false]);
    expect(page['piece-error'].textContent).toContain('no server');
    listed([1n, 0, 1]);
    await vi.advanceTimersByTimeAsync(100);
    expect([numAsked, page['piece-error'].hidden, names()]).toEqual([2, true, ['Piece 1']]);
  });

  it('leaves the keyboard and the light with a piece while others are cut', async () => {
    listed([1n, 0, 0.8], [2n, 1, 0.5]);
    panel.opened();
    await settled();
    const [, second] = rows();
    second.focus();
    expect(viewer.highlight).toHaveBeenLastCalledWith(1);
    viewer.topologyVersion = 2;
    listed([2n, 4, 0.5], [3n, 0, 0.6], [4n, 1, 0.2]);
    panel.update();
    await settled();
    expect(names()).toEqual(['Piece 3', 'Piece 2', 'Piece 4']);
    expect(FakeElement.active).toBe(second);
    expect(viewer.highlight).toHaveBeenLastCalledWith(4);
    // An element that is moved in the list loses it, too.
    viewer.topologyVersion = 3;
    listed([2n, 2, 0.7], [3n, 0, 0.6], [4n, 1, 0.2]);
    panel.update();
    await settled();
    expect([names()[0], FakeElement.active === second]).toEqual(['Piece 2', true]);
    viewer.topologyVersion = 4;
    listed([4n, 1, 0.2]);
    panel.update();
    await settled();
    expect(viewer.highlight).toHaveBeenLastCalledWith(undefined);
  });
});
