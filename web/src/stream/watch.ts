import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import type { MessageInitShape } from '@bufbuild/protobuf';
import { Ended_Reason, WatchRequestSchema, WatchResponseSchema } from '../gen/kerf/v1/stream_pb';
import type { Ended, Frame, Rejection } from '../gen/kerf/v1/stream_pb';
import { Connection, endedText, heldUs } from './connection';
import type { ConnectionState } from './connection';
import { SheetMirror } from './mirror';
import type { Delivery } from './stream_meter';

export type WatchRequestKind = MessageInitShape<typeof WatchRequestSchema>['kind'];

export interface WatchEvents {
  /** `detail` says why, for people, and is empty when all is well. */
  onState(state: ConnectionState, detail: string): void;
  /**
   * After each frame applied to `mirror`. A new mirror comes with each connection.
   * @param bytes  the WatchResponse with the frame
   */
  onFrame(mirror: SheetMirror, delivery: Delivery, bytes: Uint8Array): void;
  onRejection(rejection: Rejection): void;
}

export interface WatchOptions {
  /** Frames have strains. */
  strains?: boolean;
  /** Mirror of the same sheet by an earlier Watch: what it has is not sent again. */
  from?: SheetMirror;
  /** Each connection brings the whole topology. */
  startsWhole?: () => boolean;
}

/** Pace of the frames; see kerf.v1.WatchPace. */
export interface Pace {
  isPaused: boolean;
  /** 0: every tick */
  maxRateHz: number;
}

/**
 * Watches one sheet over WebSocket /watch and keeps watching (see Connection). Frames are applied as they come (the server
 * sends at most few unacknowledged ones, see held_us in stream.proto); the owner calls acknowledge() when it draws, and
 * setPace() when the page is hidden. A connection after the first continues from the triangles that the last one brought, if the
 * server still knows them.
 */
export class Watch {
  /** Last complete mirror: survives a lost connection, so that the last picture stays. */
  mirror: SheetMirror | undefined;

  private readonly connection: Connection;
  private incoming = new SheetMirror();
  private acknowledged = 0;
  private arrivedMs = 0;
  private pace: Pace = { isPaused: false, maxRateHz: 0 };

  /**
   * @param url   of the WebSocket, ws://HOST:PORT/watch
   * @param name  sheets/{sheet}
   */
  constructor(
    url: string,
    private readonly name: string,
    private readonly events: WatchEvents,
    private readonly options: WatchOptions = {},
  ) {
    this.connection = new Connection(url, {
      onState: (state, detail) => events.onState(state, detail),
      onOpen: () => this.start(),
      onMessage: (bytes) => this.receive(bytes),
    });
  }

  get state(): ConnectionState {
    return this.connection.state;
  }

  /** Tells the server that everything received so far has been used. Cheap when there is nothing to tell. */
  acknowledge(): void {
    if (this.incoming.sequence === this.acknowledged) return;
    const sequence = BigInt(this.incoming.sequence);
    if (this.send({ case: 'ack', value: { sequence, heldUs: heldUs(this.arrivedMs) } })) {
      this.acknowledged = this.incoming.sequence;
    }
  }

  /** While it is paused no frames come; the connection stays. */
  setPace(pace: Pace): void {
    const { isPaused, maxRateHz } = this.pace;
    if (pace.isPaused === isPaused && pace.maxRateHz === maxRateHz) return;
    this.pace = pace;
    this.connection.isPaused = pace.isPaused;
    // Before the first frame there is no pace to change; receive() looks at it.
    if (this.state === 'live') this.sendPace();
  }

  /** Sends a grab, drag or release; false if there is no connection (the server then has already let go). */
  send(kind: WatchRequestKind): boolean {
    return this.connection.send(toBinary(WatchRequestSchema, create(WatchRequestSchema, { kind })));
  }

  /** See Connection.retryNow(). */
  retryNow(): void {
    this.connection.retryNow();
  }

  close(): void {
    this.connection.close();
  }

  private sendPace(): void {
    const { isPaused: paused, maxRateHz } = this.pace;
    this.send({ case: 'pace', value: { paused, maxRateHz } });
  }

  private start(): void {
    const last = this.options.startsWhole?.() ? undefined : (this.mirror ?? this.options.from);
    this.incoming = last ? last.resumed() : new SheetMirror();
    this.acknowledged = 0;
    const { epoch } = this.incoming;
    const topologyVersion = epoch === '' ? 0 : this.incoming.topologyVersion;
    const { strains } = this.options;
    this.send({ case: 'start', value: { name: this.name, epoch, topologyVersion, strains } });
  }

  private receive(bytes: Uint8Array): void {
    const { kind } = fromBinary(WatchResponseSchema, bytes);
    if (kind.case === 'frame') this.take(kind.value, bytes);
    else if (kind.case === 'rejection') this.events.onRejection(kind.value);
    else if (kind.case === 'ended') this.ended(kind.value);
  }

  private take(frame: Frame, bytes: Uint8Array): void {
    this.arrivedMs = performance.now();
    try {
      this.incoming.apply(frame);
    } catch (error) {
      // A frame that does not fit: start again from nothing.
      this.mirror?.forgetEpoch();
      this.options.from?.forgetEpoch();
      throw error;
    }
    this.mirror = this.incoming;
    const wasLive = this.state === 'live';
    this.connection.markLive();
    if (!wasLive && (this.pace.isPaused || this.pace.maxRateHz > 0)) this.sendPace();
    const delivery: Delivery = {
      numBytes: bytes.length,
      isKeyframe: frame.baseTick === -1n,
      numUnacknowledged: this.incoming.sequence - this.acknowledged,
      decodeMs: performance.now() - this.arrivedMs,
    };
    this.events.onFrame(this.incoming, delivery, bytes);
  }

  private ended({ reason, message }: Ended): void {
    if (reason === Ended_Reason.SHEET_DELETED) this.connection.end(message || 'the sheet was deleted');
    else this.connection.expectLoss(endedText(Ended_Reason[reason], message));
  }
}
