import { create } from '@bufbuild/protobuf';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { SheetSchema } from '../src/gen/kerf/v1/sheets_pb';
import type { Sheet } from '../src/gen/kerf/v1/sheets_pb';
import type { Reporter } from '../src/notifier';
import { LiveSheet } from '../src/sheet/live_sheet';
import type { FromWorker, ToWorker } from '../src/stream/watch_messages';
import { HeldCalls } from './support/held_calls';

class FakeWorker {
  static readonly made: FakeWorker[] = [];
  readonly posted: ToWorker[] = [];
  onmessage: ((event: { data: FromWorker }) => void) | null = null;
  onerror: ((event: { message: string }) => void) | null = null;

  constructor() {
    FakeWorker.made.push(this);
  }

  postMessage(message: ToWorker): void {
    this.posted.push(message);
  }

  terminate(): void {}
}

describe('LiveSheet', () => {
  let page: { hidden: boolean };
  let wishes: { strains: boolean; pace: { isPaused: boolean; maxRateHz: number } };
  let live: LiveSheet;
  const events = {
    onState: vi.fn(),
    onFrame: vi.fn(),
    onSettings: vi.fn(),
    onRejection: vi.fn(),
    onNews: vi.fn(),
    onRecording: vi.fn(),
    onFailed: vi.fn(),
  };
  const reporter: Reporter = { notify: () => {}, attempt: (run) => run().catch(() => undefined) };
  const worker = () => FakeWorker.made.at(-1)!;
  const kinds = () => worker().posted.map(({ kind }) => kind);
  const id = () => (worker().posted.filter(({ kind }) => kind === 'start').at(-1) as { id: number }).id;

  function receive(isFirst: boolean): void {
    const frame = { positions: new Float32Array(0), stats: undefined } as never;
    worker().onmessage!({ data: { kind: 'frame', id: id(), frame, isFirst } });
  }

  beforeEach(() => {
    FakeWorker.made.length = 0;
    page = { hidden: false };
    vi.stubGlobal('Worker', FakeWorker);
    vi.stubGlobal('document', page);
    vi.stubGlobal('location', { protocol: 'http:', host: 'kerf:8080' });
    wishes = { strains: false, pace: { isPaused: false, maxRateHz: 0 } };
    for (const event of Object.values(events)) event.mockReset();
    live = new LiveSheet(() => wishes, events, reporter);
  });
  afterEach(() => vi.unstubAllGlobals());

  it('is watched with the strains and at the pace that are wanted then', () => {
    expect(live.isWatched).toBe(false);
    live.open('sheets/a');
    wishes = { strains: true, pace: { isPaused: false, maxRateHz: 10 } };
    live.restart(true);
    const started = worker().posted.filter(({ kind }) => kind === 'start');
    const url = 'ws://kerf:8080/watch';
    expect(started).toMatchObject([
      { url, name: 'sheets/a', strains: false, goesOn: false, pace: { maxRateHz: 0 } },
      { url, name: 'sheets/a', strains: true, goesOn: true, pace: { maxRateHz: 10 } },
    ]);
    expect(kinds()).toEqual(['start', 'close', 'start']);
  });

  it('keeps its name while it is not watched, and is not restarted then', () => {
    live.open('sheets/a');
    live.close();
    live.restart(false);
    expect([live.sheetName, live.isWatched, kinds()]).toEqual(['sheets/a', false, ['start', 'close']]);
  });

  it('takes no settings of a sheet that is no longer shown', async () => {
    const server = new HeldCalls();
    const settings = (name: string) => () => Promise.resolve(create(SheetSchema, { name }));
    live.open('sheets/a');
    await live.command(settings('sheets/a'));
    expect(events.onSettings.mock.calls.map(([sheet]: Sheet[]) => sheet.name)).toEqual(['sheets/a']);
    live.open('sheets/b');
    await live.command(settings('sheets/a'));
    live.close();
    await live.command(settings('sheets/b'));
    expect(events.onSettings).toHaveBeenCalledTimes(1);
    expect(server.calls).toEqual([]);
  });

  it('acknowledges the frames that come to a hidden page, where nothing is drawn', () => {
    live.open('sheets/a');
    receive(true);
    expect(kinds()).not.toContain('acknowledge');
    page.hidden = true;
    receive(false);
    expect(kinds().at(-1)).toBe('acknowledge');
    expect(events.onFrame).toHaveBeenCalledTimes(2);
  });

  it('asks for frames at the pace that is wanted once a recording has ended in a hidden page', () => {
    live.open('sheets/a');
    wishes.pace = { isPaused: true, maxRateHz: 0 };
    worker().onmessage!({ data: { kind: 'recorded', progress: {} as never, parts: [] } });
    expect(worker().posted.at(-1)).toMatchObject({ kind: 'pace', pace: { isPaused: true } });
  });

  it('says that its worker has failed, and starts another with the next sheet', () => {
    live.open('sheets/a');
    worker().onerror!({ message: 'out of memory' });
    const why = expect.stringContaining('can no longer receive the sheet: out of memory');
    expect(events.onFailed.mock.calls).toEqual([[why]]);
    expect([live.watch!.state, live.watch!.detail]).toEqual(['ended', why]);
    live.open('sheets/b');
    expect([FakeWorker.made.length, kinds()]).toEqual([2, ['start']]);
  });
});
