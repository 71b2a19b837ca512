import { create } from '@bufbuild/protobuf';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { call } from '../src/api';
import { ListStatesResponseSchema, SavedStateSchema, SheetSchema } from '../src/gen/kerf/v1/sheets_pb';
import type { Sheet } from '../src/gen/kerf/v1/sheets_pb';
import { StatePanel, freeStateId, stateFacts } from '../src/ui/state_panel';

// The part of an element that the panel uses.
class FakeElement extends EventTarget {
  children: FakeElement[] = [];
  hidden = false;
  value = '';
  placeholder = '';
  textContent = '';
  returnValue = '';

  setAttribute(): void {}
  append(...children: (FakeElement | string)[]): void {
    for (const child of children) {
      if (typeof child === 'string') this.textContent += child;
      else this.children.push(child);
    }
  }
  insertBefore(child: FakeElement, next: FakeElement | null): void {
    child.remove = () => void this.children.splice(this.children.indexOf(child), 1);
    this.children.splice(next ? this.children.indexOf(next) : this.children.length, 0, child);
  }
  remove(): void {}
  contains(): boolean {
    return false;
  }
  showModal(): void {}
  answer(value: string): void {
    this.returnValue = value;
    this.dispatchEvent(new Event('close'));
  }
}

function saved(id: string, tick = 5) {
  const name = `sheets/a/states/${id}`;
  return create(SavedStateSchema, { name, tick: BigInt(tick), numVertices: 2500, savedUnixUs: 0n });
}

describe('StatePanel', () => {
  let page: Record<string, FakeElement>;
  let states: ReturnType<typeof saved>[];
  let viewers: number;
  let panel: StatePanel;
  const sent: string[] = [];
  const notices: string[] = [];
  const at = (id: string) => (page[id] ??= new FakeElement());
  const rows = () => at('state-list').children.map(({ children }) => children[0].children.map((part) => part.textContent));

  const send = (async (method: { name: string }, request: Record<string, unknown>) => {
    if (method.name === 'ListStates') return create(ListStatesResponseSchema, { states });
    if (method.name === 'GetSheet') return create(SheetSchema, { viewers });
    sent.push(`${method.name} ${JSON.stringify(request)}`);
    if (method.name !== 'SaveState') return create(SheetSchema);
    const id = String(request.stateId);
    if (states.some(({ name }) => name.endsWith(`/${id}`))) throw new Error('it exists');
    states.push(saved(id));
    return states[states.length - 1];
  }) as unknown as typeof call;
  const live = { sheetName: 'sheets/a', command: async (run: () => Promise<Sheet>) => void (await run()) };
  const reporter = {
    notify: (kind: string, text: string) => void notices.push(`${kind}: ${text}`),
    attempt: async <T>(run: () => Promise<T>, what = '') => {
      try {
        return await run();
      } catch (error) {
        notices.push(`error: ${what}${(error as Error).message}`);
        return undefined;
      }
    },
  };

  beforeEach(async () => {
    page = {};
    states = [saved('before')];
    viewers = 1;
    sent.length = notices.length = 0;
    vi.useFakeTimers();
    vi.stubGlobal('document', {
      getElementById: (id: string) => at(id),
      createElement: () => new FakeElement(),
      createElementNS: () => new FakeElement(),
      addEventListener: () => {},
      activeElement: null,
      hidden: false,
    });
    panel = new StatePanel(live, reporter, () => 1, send);
    panel.opened();
    await vi.advanceTimersByTimeAsync(0);
  });
  afterEach(() => {
    panel.closed();
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it('lists the states, and those that others save', async () => {
    expect(rows()).toEqual([['before', expect.stringContaining('tick 5, 2,500 vertices')]]);
    expect(at('state-list-empty').hidden).toBe(true);
    states.push(saved('after', 1234));
    await vi.advanceTimersByTimeAsync(2000);
    expect(rows().map(([name]) => name)).toEqual(['before', 'after']);
    states = [];
    await vi.advanceTimersByTimeAsync(2000);
    expect([rows(), at('state-list-empty').hidden]).toEqual([[], false]);
  });

  it('saves under the name in the field, or under a free one, and says so', async () => {
    at('state-name').value = ' try ';
    await panel.save();
    expect(at('state-name').value).toBe('');
    await panel.save();
    const of = (stateId: string) => `SaveState ${JSON.stringify({ parent: 'sheets/a', stateId })}`;
    expect(sent).toEqual([of('try'), of('state-1')]);
    expect(notices).toEqual(['success: Saved as try, at tick 5', 'success: Saved as state-1, at tick 5']);
    expect(rows().map(([name]) => name)).toEqual(['before', 'try', 'state-1']);
    expect(at('state-name').placeholder).toBe('state-2');
  });

  it('keeps the name that the server refused', async () => {
    at('state-name').value = 'before';
    await panel.save();
    expect(notices).toEqual(['error: Nothing was saved: it exists']);
    expect(at('state-name').value).toBe('before');
  });

  it('goes back at once alone, and asks where others watch', async () => {
    await panel.restore('sheets/a/states/before');
    const restored = 'RestoreState {"name":"sheets/a/states/before"}';
    expect(sent.splice(0)).toEqual([restored]);
    viewers = 3;
    const refused = panel.restore('sheets/a/states/before');
    await vi.advanceTimersByTimeAsync(0);
    expect(at('confirmation-question').textContent).toBe('2 others are watching this sheet. Restore it for everyone?');
    at('confirmation').answer('no');
    await refused;
    expect(sent).toEqual([]);
    const agreed = panel.restore('sheets/a/states/before');
    await vi.advanceTimersByTimeAsync(0);
    at('confirmation').answer('yes');
    await agreed;
    expect(sent).toEqual([restored]);
  });

  it('deletes a state', async () => {
    states = [];
    await panel.remove('sheets/a/states/before');
    expect(sent).toEqual(['DeleteState {"name":"sheets/a/states/before"}']);
    expect(rows()).toEqual([]);
  });

  it('names and describes', () => {
    expect(freeStateId(['state-1', 'state-3'])).toBe('state-2');
    expect(stateFacts(saved('a', 12345))).toMatch(/^tick 12,345, 2,500 vertices, \d\d:\d\d:\d\d$/);
  });
});
