import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Connection } from '../src/stream/connection';

// A socket that opens and closes when the test says so.
class FakeSocket {
  static made: FakeSocket[] = [];
  isClosed = false;
  onopen: (() => void) | undefined;
  onclose: ((event: { reason: string }) => void) | undefined;

  constructor() {
    FakeSocket.made.push(this);
  }

  close(): void {
    this.isClosed = true;
  }
}

describe('Connection', () => {
  const onOpen = vi.fn();
  let connection: Connection;

  beforeEach(() => {
    FakeSocket.made = [];
    onOpen.mockClear();
    vi.stubGlobal('WebSocket', FakeSocket);
    connection = new Connection('ws://127.0.0.1/watch', { onState: () => {}, onOpen, onMessage: () => {} });
    connection.markLive();
    FakeSocket.made[0].onclose!({ reason: '' });
  });
  afterEach(() => {
    connection.close();
    vi.unstubAllGlobals();
  });

  it('has one socket at a time, however often it is told to try now', () => {
    connection.retryNow();
    connection.retryNow();
    const [, given, kept] = FakeSocket.made;
    expect(FakeSocket.made).toHaveLength(3);
    expect([given.isClosed, kept.isClosed]).toEqual([true, false]);
    given.onopen!();
    given.onclose!({ reason: '' });
    expect(onOpen).not.toHaveBeenCalled();
    kept.onopen!();
    expect(onOpen).toHaveBeenCalledOnce();
  });
});
