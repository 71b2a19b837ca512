import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import type { MessageInitShape } from '@bufbuild/protobuf';
import { Ended_Reason, WatchRequestSchema, WatchResponseSchema } from '../gen/kerf/v1/stream_pb';
import type { ProbeSchema } from '../gen/kerf/v1/analysis_pb';
import type { Ended, Frame, Rejection, WatchResponse } from '../gen/kerf/v1/stream_pb';
import { Connection, endedText, heldUs } from './connection';
import type { ConnectionState } from './connection';
import { SheetMirror } from './mirror';
import type { Delivery } from './stream_meter';

export type WatchRequestKind = MessageInitShape<typeof WatchRequestSchema>['kind'];

/** A quantity that the server measures for each frame; see kerf.v1.Probe. */
export type ProbeRequest = MessageInitShape<typeof ProbeSchema>;

/** A message about the others who watch the sheet. */
export type AudienceNews = Extract<WatchResponse['kind'], { case: 'audience' | 'activity' | 'pointer' }>;

export interface WatchEvents {
  /** Called for a new state; `detail` is its reason, for people, and empty when all is well. */
  onState(state: ConnectionState, detail: string): void;
  /**
   * Called after each frame applied to `mirror`. Each connection has a new mirror.
   * @param bytes  the WatchResponse with the frame
   */
  onFrame(mirror: SheetMirror, delivery: Delivery, bytes: Uint8Array): void;
  onRejection(rejection: Rejection): void;
  /** Called for each message about the audience. The first ones of a connection come before its first frame. */
  onNews(news: AudienceNews): void;
}

export interface WatchOptions {
  /** True to get frames with strains. */
  strains?: boolean;
  /** Measured on the sheet of each frame, see SheetMirror.probeValues. */
  probes?: ProbeRequest[];
  /** Mirror of an earlier Watch of the same sheet; its topology is not sent again. */
  from?: SheetMirror;
  /** Called for each connection; true to get the whole topology. */
  startsWhole?: () => boolean;
}

/** Rate of the frames; see kerf.v1.WatchPace. */
export interface Pace {
  isPaused: boolean;
  /** 0: every tick */
  maxRateHz: number;
}

/**
 * Watches one sheet over WebSocket /watch and keeps watching (see Connection). Frames are applied as they come; the
 * server sends only a few without acknowledgement (see held_us in stream.proto). The owner calls acknowledge() when it
 * draws, and setPace() when the page is hidden. Later connections continue from the last topology if the server still
 * knows it.
 */
export class Watch {
  /** Mirror after the last complete frame. It stays after a lost connection, so that the last frame remains visible. */
  mirror: SheetMirror | undefined;

  private readonly connection: Connection;
  private incoming = new SheetMirror();
  private acknowledged = 0;
  private arrivedMs = 0;
  private pace: Pace = { isPaused: false, maxRateHz: 0 };

  /**
   * @param url   address of the WebSocket, ws://HOST:PORT/watch
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

  /** Tells the server that all frames received so far have been used. Cheap if there is no new frame. */
  acknowledge(): void {
    if (this.incoming.sequence === this.acknowledged) return;
    const sequence = BigInt(this.incoming.sequence);
    if (this.send({ case: 'ack', value: { sequence, heldUs: heldUs(this.arrivedMs) } })) {
      this.acknowledged = this.incoming.sequence;
    }
  }

  /** Sets the rate of frames. While paused no frames come, but the connection stays. */
  setPace(pace: Pace): void {
    const { isPaused, maxRateHz } = this.pace;
    if (pace.isPaused === isPaused && pace.maxRateHz === maxRateHz) return;
    this.pace = pace;
    this.connection.isPaused = pace.isPaused;
    // Before the first frame nothing is sent; receive() then sends the pace.
    if (this.state === 'live') this.sendPace();
  }

  /** Sends a grab, drag, release or pointer; false if there is no connection, with which grabs and pointers end. */
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
    const { strains, probes } = this.options;
    this.send({ case: 'start', value: { name: this.name, epoch, topologyVersion, strains, probes, audience: true } });
  }

  private receive(bytes: Uint8Array): void {
    const { kind } = fromBinary(WatchResponseSchema, bytes);
    if (kind.case === 'frame') this.take(kind.value, bytes);
    else if (kind.case === 'rejection') this.events.onRejection(kind.value);
    else if (kind.case === 'ended') this.ended(kind.value);
    else if (kind.case !== undefined) this.events.onNews(kind);
  }

  private take(frame: Frame, bytes: Uint8Array): void {
    this.arrivedMs = performance.now();
    try {
      this.incoming.apply(frame);
    } catch (error) {
      // The frame does not fit the mirror, so the next connection starts with the whole topology.
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
