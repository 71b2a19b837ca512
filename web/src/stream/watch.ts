import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import type { MessageInitShape } from '@bufbuild/protobuf';
import { Ended_Reason, WatchRequestSchema, WatchResponseSchema } from '../gen/kerf/v1/stream_pb';
import type { Ended, Rejection } from '../gen/kerf/v1/stream_pb';
import { SheetMirror } from './mirror';

export type ConnectionState = 'connecting' | 'live' | 'lost' | 'ended';

export type WatchRequestKind = MessageInitShape<typeof WatchRequestSchema>['kind'];

export interface WatchEvents {
  /** `detail` says why, for people, and is empty when all is well. */
  onState(state: ConnectionState, detail: string): void;
  /** After each frame applied to `mirror`. A new mirror comes with each connection. */
  onFrame(mirror: SheetMirror): void;
  onRejection(rejection: Rejection): void;
}

export interface WatchOptions {
  /** Frames have strains. */
  strains?: boolean;
  /** Of the same sheet, by an earlier Watch: what it has is not sent again. */
  from?: SheetMirror;
}

const kFirstRetryMs = 250;
const kLastRetryMs = 8000;
// A connection that brought frames for this long was a good one: the next retry starts from the shortest wait again.
const kStableAfterMs = 5000;

/**
 * Watches one sheet over WebSocket /watch and keeps watching: a lost connection is tried again, at growing intervals,
 * until close(); a hidden page waits for retryNow(). Frames are applied as they come (the server sends at most
 * few unacknowledged ones, see held_us in stream.proto); the owner calls acknowledge() when it draws, and setPaused() when
 * nobody looks. A connection after the first goes on from the triangles that the last one brought, if the server still
 * knows them.
 */
export class Watch {
  /** Last complete mirror: survives a lost connection, so that the last picture stays. */
  mirror: SheetMirror | undefined;
  state: ConnectionState = 'connecting';

  private socket: WebSocket | undefined;
  private incoming = new SheetMirror();
  private acknowledged = 0;
  private arrivedMs = 0;
  private isPaused = false;
  private retryMs = kFirstRetryMs;
  private retryTimer: ReturnType<typeof setTimeout> | undefined;
  private liveSinceMs = 0;
  private whyLost = '';
  private isClosed = false;

  /**
   * @param url   of the WebSocket, ws://HOST:PORT/watch
   * @param name  sheets/{sheet}
   */
  constructor(
    private readonly url: string,
    private readonly name: string,
    private readonly events: WatchEvents,
    private readonly options: WatchOptions = {},
  ) {
    this.connect();
  }

  /** Tells the server that everything received so far has been used. Cheap when there is nothing to tell. */
  acknowledge(): void {
    if (this.incoming.sequence === this.acknowledged || !this.isOpen()) return;
    this.acknowledged = this.incoming.sequence;
    const heldUs = BigInt(1 + Math.max(0, Math.round(1000 * (performance.now() - this.arrivedMs))));
    this.send({ case: 'ack', value: { sequence: BigInt(this.acknowledged), heldUs } });
  }

  /** Asks for no frames until it is called with false: for a page that nobody sees. Keeps the connection. */
  setPaused(isPaused: boolean): void {
    if (isPaused === this.isPaused) return;
    this.isPaused = isPaused;
    // Before the first frame there is no pace to change; connect() and receive() look at it.
    if (this.state === 'live') this.sendPace();
  }

  /** Sends a grab, drag or release; false if there is no connection (the server then has already let go). */
  send(kind: WatchRequestKind): boolean {
    if (!this.isOpen()) return false;
    this.socket!.send(toBinary(WatchRequestSchema, create(WatchRequestSchema, { kind })) as Uint8Array<ArrayBuffer>);
    return true;
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

  private sendPace(): void {
    this.send({ case: 'pace', value: { paused: this.isPaused } });
  }

  private isOpen(): boolean {
    return this.socket !== undefined && this.socket.readyState === WebSocket.OPEN;
  }

  private connect(): void {
    const last = this.mirror ?? this.options.from;
    this.incoming = last ? last.resumed() : new SheetMirror();
    this.acknowledged = 0;
    this.whyLost = '';
    this.setState(this.mirror ? 'lost' : 'connecting', this.mirror ? 'reconnecting' : '');
    const socket = new WebSocket(this.url, 'kerf.v1');
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    const { epoch } = this.incoming;
    const topologyVersion = epoch === '' ? 0 : this.incoming.topologyVersion;
    const { strains } = this.options;
    socket.onopen = () => this.send({ case: 'start', value: { name: this.name, epoch, topologyVersion, strains } });
    socket.onmessage = (event) => this.receive(socket, new Uint8Array(event.data as ArrayBuffer));
    socket.onclose = (event) => this.closed(socket, event.reason);
  }

  private receive(socket: WebSocket, bytes: Uint8Array): void {
    if (socket !== this.socket || this.isClosed || this.whyLost !== '') return;
    try {
      const { kind } = fromBinary(WatchResponseSchema, bytes);
      if (kind.case === 'frame') {
        this.arrivedMs = performance.now();
        this.incoming.apply(kind.value);
        this.mirror = this.incoming;
        if (this.state !== 'live') {
          this.liveSinceMs = performance.now();
          this.setState('live', '');
          if (this.isPaused) this.sendPace();
        }
        this.events.onFrame(this.incoming);
      } else if (kind.case === 'rejection') {
        this.events.onRejection(kind.value);
      } else if (kind.case === 'ended') {
        this.ended(kind.value);
      }
    } catch (error) {
      // A frame that does not fit: start anew from nothing.
      this.mirror?.forgetEpoch();
      this.options.from?.forgetEpoch();
      this.whyLost = (error as Error).message;
      socket.close();
    }
  }

  private ended(ended: Ended): void {
    if (ended.reason === Ended_Reason.SHEET_DELETED) {
      this.isClosed = true;
      this.setState('ended', ended.message || 'the sheet was deleted');
      this.socket?.close();
      return;
    }
    this.whyLost = ended.message || Ended_Reason[ended.reason].toLowerCase().replaceAll('_', ' ');
  }

  private closed(socket: WebSocket, reason: string): void {
    if (socket !== this.socket || this.isClosed) return;
    if (this.state === 'live' && performance.now() - this.liveSinceMs > kStableAfterMs) this.retryMs = kFirstRetryMs;
    const why = this.whyLost || reason || 'no connection to the server';
    if (this.isPaused) {
      // Nobody looks, and a page that draws nothing acknowledges nothing: wait for retryNow().
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
