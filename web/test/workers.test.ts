import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { startWorker } from '../src/stream/workers';

class FakeWorker {
  static last: FakeWorker;
  isEnded = false;
  onerror: ((event: { message?: string }) => void) | null = null;
  onmessageerror: (() => void) | null = null;

  constructor(readonly url: URL) {
    FakeWorker.last = this;
  }

  terminate(): void {
    this.isEnded = true;
  }
}

describe('startWorker', () => {
  const failed = vi.fn();

  beforeEach(() => {
    failed.mockClear();
    vi.stubGlobal('Worker', FakeWorker);
  });
  afterEach(() => vi.unstubAllGlobals());

  it.each(['watch', 'images', 'replay'] as const)('tells that the worker of %s has failed, and ends it', (name) => {
    for (const [fail, why] of [
      [() => FakeWorker.last.onerror?.({}), 'its program cannot be loaded'],
      [() => FakeWorker.last.onerror?.({ message: 'Uncaught Error: broken' }), 'Uncaught Error: broken'],
      [() => FakeWorker.last.onmessageerror?.(), 'its messages cannot be read'],
    ] as const) {
      startWorker(name, failed);
      fail();
      fail();
      expect(failed.mock.calls.splice(0)).toEqual([[why]]);
      expect(FakeWorker.last.isEnded).toBe(true);
    }
  });
});
