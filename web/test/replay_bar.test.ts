import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { ReplayBar } from '../src/ui/replay_bar';

class FakeWorker {
  static made: FakeWorker[] = [];
  isEnded = false;
  readonly opened: number[] = [];
  onmessage: ((event: { data: unknown }) => void) | undefined;
  onerror: ((event: { message: string }) => void) | undefined;

  constructor() {
    FakeWorker.made.push(this);
  }

  postMessage({ file }: { file: ArrayBuffer }): void {
    this.opened.push(file.byteLength);
  }

  terminate(): void {
    this.isEnded = true;
  }
}

describe('ReplayBar', () => {
  let page: Record<string, { hidden: boolean; click(): void }>;
  let bar: ReplayBar;
  let numClosed: number;
  const notices: string[] = [];

  // Makes a file whose bytes come when `read` is called.
  function slowFile(numBytes: number): { file: File; read: () => Promise<void> } {
    let resolve: (bytes: ArrayBuffer) => void;
    const bytes = new Promise<ArrayBuffer>((give) => (resolve = give));
    const file = { name: `${numBytes}.kerfstream`, size: numBytes, arrayBuffer: () => bytes } as File;
    const read = async () => {
      resolve(new ArrayBuffer(numBytes));
      await bytes;
    };
    return { file, read };
  }

  function fakeElement() {
    const listeners: Record<string, () => void> = {};
    const addEventListener = (type: string, act: () => void) => void (listeners[type] = act);
    return { hidden: true, value: 0, addEventListener, click: () => listeners.click?.() };
  }

  beforeEach(() => {
    page = {};
    FakeWorker.made = [];
    notices.length = numClosed = 0;
    vi.stubGlobal('Worker', FakeWorker);
    vi.stubGlobal('document', {
      getElementById: (id: string) => (page[id] ??= fakeElement()),
      querySelectorAll: () => [],
    });
    const events = { onOpened: () => {}, onFrame: () => {}, onClosed: () => void (numClosed += 1) };
    bar = new ReplayBar(events, { notify: (kind, text) => void notices.push(`${kind}: ${text}`) });
  });
  afterEach(() => vi.unstubAllGlobals());

  it('plays the file that was chosen last, whichever is read first', async () => {
    const [large, small] = [slowFile(1000), slowFile(10)];
    const opening = [bar.open(large.file), bar.open(small.file)];
    await small.read();
    await large.read();
    await Promise.all(opening);
    expect(FakeWorker.made.map(({ opened }) => opened)).toEqual([[10]]);
    expect(FakeWorker.made[0].isEnded).toBe(false);
  });

  it.each([
    ['Escape', () => expect(bar.key('Escape')).toBe(true)],
    ['its button', () => page['replay-close'].click()],
  ])('is given up by %s while the file is read, and while it is checked', async (_, giveUp) => {
    const { file, read } = slowFile(10);
    const opening = bar.open(file);
    expect(page.replay.hidden).toBe(false);
    giveUp();
    expect(page.replay.hidden).toBe(true);
    await read();
    await opening;
    expect(FakeWorker.made).toEqual([]);

    const again = slowFile(20);
    await Promise.all([bar.open(again.file), again.read()]);
    expect(FakeWorker.made[0].opened).toEqual([20]);
    giveUp();
    expect([FakeWorker.made[0].isEnded, page.replay.hidden]).toEqual([true, true]);
    expect([bar.key('Escape'), notices]).toEqual([false, []]);
  });

  it('goes back to the live sheet while another recording is read, so that keys reach what is seen', async () => {
    const first = slowFile(10);
    await Promise.all([bar.open(first.file), first.read()]);
    numClosed = 0;
    const second = slowFile(20);
    const opening = bar.open(second.file);
    expect([numClosed, bar.hasFile]).toEqual([1, true]);
    await Promise.all([opening, second.read()]);
    expect(FakeWorker.made.map(({ opened }) => opened)).toEqual([[10], [20]]);
  });

  it('closes, and says why, where its worker has failed', async () => {
    const { file, read } = slowFile(10);
    await Promise.all([bar.open(file), read()]);
    FakeWorker.made[0].onerror!({ message: 'out of memory' });
    expect(notices).toEqual(['error: 10.kerfstream cannot be played: the player failed: out of memory']);
    expect(page.replay.hidden).toBe(true);
  });
});
