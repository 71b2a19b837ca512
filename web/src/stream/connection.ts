export type ConnectionState = 'connecting' | 'live' | 'lost' | 'ended';

export interface ConnectionEvents {
  /** `detail` says why, for people, and is empty when all is well. */
  onState(state: ConnectionState, detail: string): void;
  /** Called when the socket is open, to send the first messages of a stream. */
  onOpen(): void;
  /**
   * Called for each message. An exception ends this connection, with its message as the reason, and another is tried.
   */
  onMessage(bytes: Uint8Array): void;
  /** Returns true if trying again is useless after the server closed the connection for this reason. */
  isFinal?(reason: string): boolean;
}

const kFirstRetryMs = 250;
// Longest wait between two tries, so that a server that is back is found within 2 s.
const kLastRetryMs = 1600;
// After a connection that was live for this long, the next retry starts with the shortest wait again.
const kStableAfterMs = 5000;

/**
 * A WebSocket of subprotocol kerf.v1 that is kept open. A lost connection is retried at growing intervals until
 * close(); while paused, it waits for retryNow().
 */
export class Connection {
  state: ConnectionState = 'connecting';
  /** True while the page is hidden: a lost connection is then retried only by retryNow(). */
  isPaused = false;

  private socket: WebSocket | undefined;
  private retryMs = kFirstRetryMs;
  private retryTimer: ReturnType<typeof setTimeout> | undefined;
  private hasBeenLive = false;
  private liveSinceMs = 0;
  private whyLost = '';
  private isClosed = false;

  /** @param url  address of the WebSocket, ws://HOST:PORT/watch */
  constructor(
    private readonly url: string,
    private readonly events: ConnectionEvents,
  ) {
    this.connect();
  }

  /** Sends a message; false if there is no connection. */
  send(bytes: Uint8Array): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(bytes as Uint8Array<ArrayBuffer>);
    return true;
  }

  /** Call it when the stream has delivered its first frame or picture. */
  markLive(): void {
    if (this.state === 'live') return;
    this.hasBeenLive = true;
    this.liveSinceMs = performance.now();
    this.setState('live', '');
  }

  /**
   * Call it when the server announces the end of this connection; `why` is its reason. Another is tried after the end.
   */
  expectLoss(why: string): void {
    this.whyLost = why;
  }

  /** Ends the connection for good. */
  end(detail: string): void {
    this.isClosed = true;
    this.setState('ended', detail);
    this.socket?.close();
  }

  /** Tries again now rather than at the end of the present wait, for instance when the page becomes visible. */
  retryNow(): void {
    if (this.state !== 'lost' || this.isClosed) return;
    clearTimeout(this.retryTimer);
    this.connect();
  }

  close(): void {
    this.isClosed = true;
    clearTimeout(this.retryTimer);
    this.socket?.close();
  }

  private connect(): void {
    this.whyLost = '';
    // Closes the old socket: if it is still opening, it would become a second stream.
    this.socket?.close();
    this.setState(this.hasBeenLive ? 'lost' : 'connecting', this.hasBeenLive ? 'reconnecting' : '');
    const socket = new WebSocket(this.url, 'kerf.v1');
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => socket === this.socket && this.events.onOpen();
    socket.onmessage = (event) => this.receive(socket, new Uint8Array(event.data as ArrayBuffer));
    socket.onclose = (event) => this.closed(socket, event.reason);
  }

  private receive(socket: WebSocket, bytes: Uint8Array): void {
    if (socket !== this.socket || this.isClosed || this.whyLost !== '') return;
    try {
      this.events.onMessage(bytes);
    } catch (error) {
      this.whyLost = (error as Error).message;
      socket.close();
    }
  }

  private closed(socket: WebSocket, reason: string): void {
    if (socket !== this.socket || this.isClosed) return;
    if (this.state === 'live' && performance.now() - this.liveSinceMs > kStableAfterMs) this.retryMs = kFirstRetryMs;
    const why = this.whyLost || reason || 'no connection to the server';
    if (this.events.isFinal?.(reason)) {
      this.end(why);
      return;
    }
    if (this.isPaused) {
      // A hidden page draws nothing and would acknowledge nothing, so it waits for retryNow().
      this.setState('lost', why);
      return;
    }
    this.setState('lost', `${why}; trying again in ${(this.retryMs / 1000).toLocaleString('en')} s`);
    this.retryTimer = setTimeout(() => this.connect(), this.retryMs);
    this.retryMs = Math.min(2 * this.retryMs, kLastRetryMs);
  }

  private setState(state: ConnectionState, detail: string): void {
    this.state = state;
    this.events.onState(state, detail);
  }
}

/** Describes a stream's last message, for people. */
export function endedText(reasonName: string, message: string): string {
  return message || reasonName.toLowerCase().replaceAll('_', ' ');
}

/** Returns the microseconds, >= 1, since `arrivedMs` (performance.now()), for held_us of stream.proto. */
export function heldUs(arrivedMs: number): bigint {
  return BigInt(1 + Math.max(0, Math.round(1000 * (performance.now() - arrivedMs))));
}
