import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import type { MessageInitShape } from '@bufbuild/protobuf';
import { WatchImagesRequestSchema, WatchImagesResponseSchema } from '../gen/kerf/v1/render_pb';
import type { Image, ImageCodec, ImageViewSchema } from '../gen/kerf/v1/render_pb';
import type { Camera } from '../gen/kerf/v1/geometry_pb';
import { Ended_Reason } from '../gen/kerf/v1/stream_pb';
import type { Ended, FrameStats } from '../gen/kerf/v1/stream_pb';
import { Connection, endedText, heldUs } from './connection';
import type { ConnectionState } from './connection';
import { unixTimeMs } from './frame_clock';
import type { openDecoder, Picture, PictureDecoder } from './picture_decoder';
import type { Delivery } from './stream_meter';
import type { Pace } from './watch';

export type ImageView = MessageInitShape<typeof ImageViewSchema>;

/** A picture of the sheet, decoded. */
export interface ShownPicture {
  picture: Picture;
  sequence: number;
  tick: number;
  stats: FrameStats | undefined;
  /** Camera that the picture was drawn with. */
  camera: Camera | undefined;
  /** Strain (-) at the end of the colour scale; 0: not coloured by strain. */
  strainEnd: number;
  delivery: Delivery;
  /** Arrival, this machine's Unix time, milliseconds. */
  arrivedMs: number;
}

/**
 * Reason why pictures cannot be shown with this codec: the first word of the server's close reason, or UNDECODABLE from
 * the viewer.
 */
export type Refusal = 'RENDERER_UNAVAILABLE' | 'NO_VIDEO_CODEC' | 'UNDECODABLE';

export interface ImageWatchEvents {
  onState(state: ConnectionState, detail: string): void;
  onPicture(shown: ShownPicture): void;
  /** Called when the watch has ended for this reason. */
  onRefused(refusal: Refusal, message: string): void;
}

// After this many errors without a picture between them the decoder counts as broken.
const kMaxErrors = 3;

interface Arrival {
  atMs: number;
  unixMs: number;
  image: Image;
  numBytes: number;
  numUnacknowledged: number;
}

/**
 * Watches one sheet in pictures over WebSocket /images and keeps watching (see Connection). The owner acknowledges the
 * pictures that it has drawn, and the server draws no more than that.
 */
export class ImageWatch {
  private readonly connection: Connection;
  private decoder: PictureDecoder | undefined;
  private readonly arrivals = new Map<number, Arrival>();
  private acknowledged = 0;
  private pace: Pace = { isPaused: false, maxRateHz: 0 };
  // True if the next image can be decoded from those before; false from an error until the next key image.
  private isFollowed = true;
  private numErrors = 0;

  /**
   * @param url   address of the WebSocket, ws://HOST:PORT/images
   * @param name  sheets/{sheet}
   */
  constructor(
    url: string,
    private readonly name: string,
    private readonly codec: ImageCodec,
    private view: ImageView,
    private readonly events: ImageWatchEvents,
    private readonly makeDecoder: typeof openDecoder,
  ) {
    this.connection = new Connection(url, {
      onState: (state, detail) => events.onState(state, detail),
      onOpen: () => this.start(),
      onMessage: (bytes) => this.receive(bytes),
      isFinal: (reason) => this.isRefused(reason),
    });
  }

  /** Sets the view from the next picture on. */
  setView(view: ImageView): void {
    this.view = view;
    this.send({ case: 'view', value: view });
  }

  /** See Watch.setPace(). */
  setPace(pace: Pace): void {
    this.pace = pace;
    this.connection.isPaused = pace.isPaused;
    if (this.connection.state === 'live') this.sendPace();
  }

  /** Tells the server that the picture with this sequence number, and all before it, have been used. */
  acknowledge(sequence: number): void {
    const arrival = this.arrivals.get(sequence);
    if (!arrival) return;
    this.send({ case: 'ack', value: { sequence: BigInt(sequence), heldUs: heldUs(arrival.atMs) } });
    this.acknowledged = sequence;
    for (const before of this.arrivals.keys()) if (before <= sequence) this.arrivals.delete(before);
  }

  retryNow(): void {
    this.connection.retryNow();
  }

  close(): void {
    this.connection.close();
    this.decoder?.close();
  }

  private send(kind: MessageInitShape<typeof WatchImagesRequestSchema>['kind']): void {
    this.connection.send(toBinary(WatchImagesRequestSchema, create(WatchImagesRequestSchema, { kind })));
  }

  private sendPace(): void {
    this.send({ case: 'pace', value: { paused: this.pace.isPaused, maxRateHz: this.pace.maxRateHz } });
  }

  private start(): void {
    const { name, codec, view } = this;
    this.arrivals.clear();
    this.acknowledged = 0;
    this.isFollowed = true;
    this.decoder?.close();
    this.decoder = this.makeDecoder(codec, {
      onPicture: (picture, sequence) => this.show(picture, sequence),
      onError: (message) => this.lostPlace(message),
    });
    this.send({ case: 'start', value: { name, codec, view, maxRateHz: this.pace.maxRateHz } });
  }

  private receive(bytes: Uint8Array): void {
    const { kind } = fromBinary(WatchImagesResponseSchema, bytes);
    if (kind.case === 'image') this.take(kind.value, bytes.length);
    else if (kind.case === 'ended') this.ended(kind.value);
  }

  private take(image: Image, numBytes: number): void {
    const sequence = Number(image.sequence);
    const numUnacknowledged = sequence - this.acknowledged;
    const [atMs, unixMs] = [performance.now(), unixTimeMs()];
    this.arrivals.set(sequence, { atMs, unixMs, image, numBytes, numUnacknowledged });
    const wasLive = this.connection.state === 'live';
    this.connection.markLive();
    if (!wasLive && this.pace.isPaused) this.sendPace();
    if (image.key) this.isFollowed = true;
    // After an error, pictures that build on a lost one are not decoded. They are still acknowledged, because the
    // server would otherwise send no more.
    if (this.isFollowed) this.decode(image);
    else this.acknowledge(sequence);
  }

  private decode(image: Image): void {
    try {
      this.decoder!.decode(image);
    } catch (error) {
      this.lostPlace((error as Error).message);
    }
  }

  // Handles a decoding error: sends the view again, so that the server sends an image that can be decoded by itself.
  private lostPlace(message: string): void {
    this.isFollowed = false;
    this.numErrors += 1;
    if (this.numErrors >= kMaxErrors) {
      this.connection.end(message);
      this.events.onRefused('UNDECODABLE', message);
      return;
    }
    this.setView(this.view);
    const last = Math.max(...this.arrivals.keys());
    if (Number.isFinite(last)) this.acknowledge(last);
  }

  private show(picture: Picture, sequence: number): void {
    const arrival = this.arrivals.get(sequence);
    // The picture belongs to an earlier connection, or was skipped.
    if (!arrival) return picture.close();
    this.numErrors = 0;
    const { image, atMs, unixMs, numBytes, numUnacknowledged } = arrival;
    this.events.onPicture({
      picture,
      sequence,
      tick: Number(image.tick),
      stats: image.stats,
      camera: image.camera,
      strainEnd: image.strainEnd,
      arrivedMs: unixMs,
      delivery: { numBytes, isKeyframe: image.key, numUnacknowledged, decodeMs: performance.now() - atMs },
    });
  }

  private ended({ reason, message }: Ended): void {
    if (reason === Ended_Reason.SHEET_DELETED) this.connection.end(message || 'the sheet was deleted');
    else this.connection.expectLoss(endedText(Ended_Reason[reason], message));
  }

  private isRefused(reason: string): boolean {
    const [, code, message] = /^(RENDERER_UNAVAILABLE|NO_VIDEO_CODEC): (.*)$/.exec(reason) ?? [];
    if (code) this.events.onRefused(code as Refusal, message);
    return code !== undefined;
  }
}
