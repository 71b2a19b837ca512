import { create } from '@bufbuild/protobuf';
import type { MessageInitShape } from '@bufbuild/protobuf';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { AccessSchema, Scope } from '../src/gen/kerf/v1/access_service_pb';
import { ActivitySchema, AudienceSchema, PointerSchema, ViewerSchema } from '../src/gen/kerf/v1/stream_pb';
import type { Viewer } from '../src/tools/tool';
import { People } from '../src/ui/people/people';
import { StageFromAbove, flatSheet } from './support/flat_sheet';

// The parts of an element that the panel and the dots use.
class FakeElement extends EventTarget {
  children: (FakeElement | string)[] = [];
  className = '';
  value = '';
  hidden = false;
  parent: FakeElement | undefined;
  readonly attributes: Record<string, string> = {};
  readonly style = { transform: '', setProperty: () => {} };
  readonly classList = { toggle: () => {} };
  readonly focus = vi.fn();

  get textContent(): string {
    return this.children.map((child) => (typeof child === 'string' ? child : child.textContent)).join('|');
  }
  set textContent(text: string) {
    this.children = [text];
  }
  setAttribute(name: string, value: string): void {
    this.attributes[name] = value;
  }
  append(...children: (FakeElement | string)[]): void {
    for (const child of children) if (typeof child !== 'string') child.parent = this;
    this.children.push(...children);
  }
  replaceChildren(...children: (FakeElement | string)[]): void {
    this.children = [];
    this.append(...children);
  }
  remove(): void {
    this.parent!.children = this.parent!.children.filter((child) => child !== this);
  }
}

describe('People', () => {
  const elements = new Map<string, FakeElement>();
  const at = (id: string) => {
    if (!elements.has(id)) elements.set(id, new FakeElement());
    return elements.get(id)!;
  };
  const texts = (id: string) => at(id).children.map((child) => (child as FakeElement).textContent);
  const imageMode = { isOn: false };
  const toggle = vi.fn();
  const notify = vi.fn();
  let overlay: FakeElement;
  let people: People;

  const listed = (ownNumber: number, numViewers: number, ...viewers: MessageInitShape<typeof ViewerSchema>[]) =>
    people.take({ case: 'audience', value: create(AudienceSchema, { ownNumber, numViewers, viewers }) });
  const did = (tokenId: string, call: string, unixUs = 0n, byLink = false) =>
    people.take({ case: 'activity', value: create(ActivitySchema, { tokenId, call, unixUs, byLink }) });
  const points = (viewer: number, material?: { x: number; y: number }) =>
    people.take({ case: 'pointer', value: create(PointerSchema, { viewer, material }) });

  const kLab = { number: 1, tokenId: 'lab', scope: Scope.ADMIN };
  const kGuest = { number: 2, tokenId: 'lab', scope: Scope.VIEW, byLink: true };
  const kBob = { number: 3, tokenId: 'bob', scope: Scope.CUT };

  beforeEach(() => {
    elements.clear();
    vi.useFakeTimers({ toFake: ['Date', 'performance'], now: new Date(2026, 4, 3, 15, 0) });
    vi.stubGlobal('document', { getElementById: at, createElement: () => new FakeElement() });
    vi.stubGlobal('location', { origin: 'https://lab:8443' });
    imageMode.isOn = false;
    overlay = new FakeElement();
    toggle.mockReset();
    notify.mockReset();
    const live = { sheetName: 'sheets/demo', watch: undefined };
    const shown = { surface: flatSheet().surface };
    const viewer = { stage: new StageFromAbove(), overlay, shown, live, notices: { notify } } as unknown as Viewer;
    people = new People({ viewer, tools: { keyboardPointer: { at: undefined } }, imageMode, panels: { toggle } });
  });

  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it('counts the others on the button, also while the panel is closed', () => {
    people.update();
    expect(at('people-count').hidden).toBe(true);
    listed(1, 1, kLab);
    people.update();
    expect(at('people-count').hidden).toBe(true);
    listed(1, 70, kLab, kGuest);
    people.update();
    expect([at('people-count').hidden, at('people-count').textContent]).toEqual([false, '69| others']);
    listed(1, 2, kLab, kGuest);
    people.update();
    expect(at('people-count').textContent).toBe('1| other');
    expect(at('people-list').children).toEqual([]);
  });

  it('does not count the pictures of this page', () => {
    listed(1, 2, kLab, { ...kLab, number: 9, pictures: true });
    people.update();
    expect(at('people-count').hidden).toBe(false);
    imageMode.isOn = true;
    people.update();
    expect(at('people-count').hidden).toBe(true);
  });

  it('lists who is there, this user first and marked', () => {
    people.panel.opened();
    expect(at('people-summary').textContent).toBe('Not connected to the sheet.');
    expect(at('people-unchanged').hidden).toBe(true);
    listed(3, 4, kLab, kGuest, kBob);
    people.update();
    expect(at('people-summary').textContent).toBe('You and 3 others watch this sheet.');
    expect(texts('people-list')).toEqual(['bob|you|look and cut', 'lab|everything', 'guest of lab|look only']);
    expect(at('people-rest').textContent).toBe('and 1 more');
    expect(at('people-unchanged').hidden).toBe(false);
    listed(3, 1, kBob);
    people.update();
    expect([at('people-summary').textContent, at('people-rest').textContent]).toEqual(['You are alone here.', '']);
  });

  it('lists what they did, the newest first, and renews nothing while nothing changes', () => {
    const time = (minute: number) => BigInt(new Date(2026, 4, 3, 14, minute).getTime()) * 1000n;
    people.panel.opened();
    listed(1, 1, kLab);
    did('alice', 'CreateCut', time(1));
    did('alice', 'CreateCut', time(2));
    did('lab', 'ResetSheet', time(4), true);
    people.update();
    expect(texts('people-changes')).toEqual(['guest of lab reset the sheet|14:04', 'alice cut twice|14:02']);
    expect(at('people-unchanged').hidden).toBe(true);
    const [first] = at('people-changes').children;
    people.update();
    expect(at('people-changes').children[0]).toBe(first);
  });

  it('forgets all at another connection, which begins with all of it', () => {
    people.panel.opened();
    listed(1, 2, kLab, kBob);
    did('bob', 'CreateCut');
    points(3, { x: 0.5, y: 0.5 });
    people.clear();
    people.update();
    expect([texts('people-list'), texts('people-changes'), overlay.children]).toEqual([[], [], []]);
    expect([at('people-count').hidden, at('people-summary').textContent]).toEqual([true, 'Not connected to the sheet.']);
    listed(4, 1, { ...kLab, number: 4 });
    did('bob', 'CreateCut');
    people.update();
    expect(texts('people-changes')).toHaveLength(1);
    expect(at('people-joined').textContent).toBe('');
  });

  it('announces who joins, politely and only then', () => {
    listed(1, 1, kLab);
    expect(at('people-joined').textContent).toBe('');
    listed(1, 2, kLab, kGuest);
    expect(at('people-joined').textContent).toBe('guest of lab has joined');
    at('people-joined').replaceChildren();
    listed(1, 1, kLab);
    did('bob', 'CreateCut');
    expect(at('people-joined').textContent).toBe('');
  });

  it('shows dots with names where others point, until they stop or leave', () => {
    listed(1, 3, kLab, kGuest, kBob);
    points(2, { x: 0.25, y: 0.5 });
    points(3, { x: 0.5, y: 0.75 });
    people.place();
    const dots = () => overlay.children.map((dot) => [(dot as FakeElement).textContent, (dot as FakeElement).style.transform]);
    expect(dots()).toEqual([
      ['guest of lab', 'translate(25.0px, 50.0px)'],
      ['bob', 'translate(50.0px, 75.0px)'],
    ]);
    expect(people.arePointersShown).toBe(true);
    listed(1, 2, kLab, kBob);
    expect(dots().map(([name]) => name)).toEqual(['bob']);
    points(3);
    expect([dots(), people.arePointersShown]).toEqual([[], false]);
    // A viewer beyond those that are listed.
    points(80, { x: 0, y: 0 });
    expect(dots().map(([name]) => name)).toEqual(['someone']);
  });

  it('leads to links where the server makes them, and else to the address', async () => {
    const share = () => [at('people-share').hidden, at('people-open').hidden];
    people.panel.show(create(AccessSchema, { asksForTokens: true }));
    expect(share()).toEqual([false, true]);
    at('people-share').dispatchEvent(new Event('click'));
    expect(toggle.mock.calls).toEqual([['access']]);
    expect(at('share-scope').focus).toHaveBeenCalledOnce();
    people.panel.show(create(AccessSchema, { asksForTokens: false }));
    expect(share()).toEqual([true, false]);
    people.panel.opened();
    expect(at('people-address').value).toBe('https://lab:8443/?sheet=demo');
    const writeText = vi.fn();
    vi.stubGlobal('navigator', { clipboard: { writeText } });
    at('people-copy').dispatchEvent(new Event('click'));
    await Promise.resolve();
    expect(writeText.mock.calls).toEqual([['https://lab:8443/?sheet=demo']]);
    people.panel.show(undefined);
    expect(share()).toEqual([true, true]);
  });
});
