import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { ApiError, fetchFile } from '../src/api';
import type { TransferOptions } from '../src/api';
import { Transfer } from '../src/ui/transfer';

// Parts of the page that it touches.
function fakeElement() {
  const listeners: Record<string, () => void> = {};
  return {
    hidden: true,
    textContent: '',
    value: undefined as number | undefined,
    removeAttribute(name: string) {
      if (name === 'value') this.value = undefined;
    },
    addEventListener: (type: string, act: () => void) => void (listeners[type] = act),
    click: () => listeners.click(),
  };
}

describe('Transfer', () => {
  let page: Record<string, ReturnType<typeof fakeElement>>;
  let notices: string[];
  let transfer: Transfer;
  let nowMs: number;

  beforeEach(() => {
    page = Object.fromEntries(['', '-progress', '-cancel', '-text'].map((end) => [`transfer${end}`, fakeElement()]));
    vi.stubGlobal('document', { getElementById: (id: string) => page[id] });
    nowMs = 0;
    vi.spyOn(performance, 'now').mockImplementation(() => nowMs);
    notices = [];
    transfer = new Transfer({ notify: (kind, text) => void notices.push(`${kind}: ${text}`) });
  });

  afterEach(() => {
    vi.unstubAllGlobals();
    vi.restoreAllMocks();
  });

  /** A transfer that runs until the test ends it. */
  function start() {
    let options!: TransferOptions;
    let end!: (result: string) => void;
    let fail!: (error: Error) => void;
    const result = transfer.run('Sending a.rec', 'a.rec is not played: ', (given) => {
      options = given;
      return new Promise<string>((resolve, reject) => {
        end = resolve;
        fail = reject;
        given.signal.addEventListener('abort', () => reject(new Error('aborted')));
      });
    });
    return { result, options, end, fail };
  }

  it('shows itself once it takes long, then that the server is at work, and goes', async () => {
    const { result, options, end } = start();
    options.onProgress(0.1);
    expect(page.transfer.hidden).toBe(true);
    nowMs = 1000;
    options.onProgress(0.5);
    expect([page.transfer.hidden, page['transfer-text'].textContent]).toEqual([false, 'Sending a.rec']);
    expect(page['transfer-progress'].value).toBe(0.5);
    options.onProgress(1);
    expect(page['transfer-progress'].value).toBeUndefined();
    expect(transfer.isOn).toBe(true);
    end('sheet');
    expect(await result).toBe('sheet');
    expect([page.transfer.hidden, transfer.isOn, notices]).toEqual([true, false, []]);
  });

  it('takes one at a time, and says what failed', async () => {
    const { result, fail } = start();
    expect(await start().result).toBeUndefined();
    fail(new ApiError('INVALID_ARGUMENT', 'damaged at byte 12'));
    expect(await result).toBeUndefined();
    expect(notices).toEqual([
      'error: a.rec is not played: another file is being transferred. Wait for it, or cancel it',
      'error: a.rec is not played: damaged at byte 12',
    ]);
  });

  it('is cancelled by its button', async () => {
    const { result } = start();
    page['transfer-cancel'].click();
    expect(await result).toBeUndefined();
    expect([notices, transfer.isOn]).toEqual([['info: a.rec is not played: it was cancelled'], false]);
  });
});

describe('fetchFile', () => {
  afterEach(() => vi.unstubAllGlobals());

  const options = (told: number[]): TransferOptions => ({
    signal: new AbortController().signal,
    onProgress: (part) => void told.push(part),
  });

  it('gives all parts, and tells how much has come', async () => {
    const chunks = [new Uint8Array([1, 2, 3]), new Uint8Array([4])];
    const body = new ReadableStream({
      start(controller) {
        for (const chunk of chunks) controller.enqueue(chunk);
        controller.close();
      },
    });
    vi.stubGlobal('fetch', async () => new Response(body, { headers: { 'content-length': '4' } }));
    const told: number[] = [];
    expect(await fetchFile('/sheets/a.rec', options(told))).toEqual(chunks);
    expect(told).toEqual([0.75, 1]);
  });

  it('fails with the server’s words', async () => {
    const refusal = JSON.stringify({ code: 9, message: 'it had outgrown 16 MiB' });
    vi.stubGlobal('fetch', async () => new Response(refusal, { status: 400 }));
    const failure = await fetchFile('/sheets/a.rec', options([])).catch((error: unknown) => error);
    expect(failure).toMatchObject({ code: 'FAILED_PRECONDITION', message: 'it had outgrown 16 MiB' });
  });
});
