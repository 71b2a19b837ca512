export type ConnectionState = 'connecting' | 'live' | 'lost' | 'ended';

export interface ConnectionEvents {
  /** `detail` says why, for people, and is empty when all is well. */
  onState(state: ConnectionState, detail: string): void;
  /** The socket is open: time to send what a stream begins with. */
  onOpen(): void;
  /** An exception ends this connection, with its message as the reason, and another is tried. */
  onMessage(bytes: Uint8Array): void;
  /** The server closed the connection, with this reason: true if trying again is of no use. */
  isFinal?(reason: string): boolean;
}

const kFirstRetryMs = 250;
const kLastRetryMs = 8000;
// A connection that was live for this long was a good one: the next retry starts from the shortest wait again.
const kStableAfterMs = 5000;

/**
 * A WebSocket of subprotocol kerf.v1 that is kept alive: a lost one is tried again, at growing intervals, until close();
 * a paused one waits for retryNow().
 */
export class Connection {
  state: ConnectionState = 'connecting';
  /** True while the page is hidden: a connection that is lost is not tried again by itself. */
  isPaused = false;

  private socket: WebSocket | undefined;
  private retryMs = kFirstRetryMs;
  private retryTimer: ReturnType<typeof setTimeout> | undefined;
  private hasBeenLive = false;
  private liveSinceMs = 0;
  private whyLost = '';
  private isClosed = false;

  /** @param url  of the WebSocket, ws://HOST:PORT/watch */
  constructor(
    private readonly url: string,
    private readonly events: ConnectionEvents,
  ) {
    this.connect();
  }

  /** False if there is no connection. */
  send(bytes: Uint8Array): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(bytes as Uint8Array<ArrayBuffer>);
    return true;
  }

  /** The stream has brought what it is there for. */
  markLive(): void {
    if (this.state === 'live') return;
    this.hasBeenLive = true;
    this.liveSinceMs = performance.now();
    this.setState('live', '');
  }

  /** The other side says that this connection ends, and why; the next is tried once it has. */
  expectLoss(why: string): void {
    this.whyLost = why;
  }

  /** Ended for good. */
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
    // One that is only being opened would become a second stream.
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
      // A page that draws nothing acknowledges nothing: wait for retryNow().
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

/** Microseconds, >= 1, since `arrivedMs` (performance.now()): held_us of stream.proto. */
export function heldUs(arrivedMs: number): bigint {
  return BigInt(1 + Math.max(0, Math.round(1000 * (performance.now() - arrivedMs))));
}
