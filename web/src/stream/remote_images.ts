import type { ImageCodec } from '../gen/kerf/v1/render_pb';
import type { ConnectionState } from './connection';
import type { FromImages, ToImages } from './image_messages';
import type { ImageView, Refusal, ShownPicture } from './image_watch';
import type { Pace } from './watch';
import type { Port } from './watch_messages';

export interface RemoteImagesEvents {
  onState(): void;
  /** Called when a picture can be drawn. */
  onPicture(shown: ShownPicture): void;
  /** Called when the stream has ended because pictures cannot be shown with this codec. */
  onRefused(refusal: Refusal, message: string): void;
}

export interface RemoteImagesOptions {
  codec: ImageCodec;
  view: ImageView;
  pace: Pace;
}

/** The page's side of an ImageWatch that runs in a worker. One at a time per port. */
export class RemoteImages {
  state: ConnectionState = 'connecting';
  /** Reason of the state, for people; empty when all is well. */
  detail = '';

  private static lastId = 0;
  private readonly id = ++RemoteImages.lastId;
  private isClosed = false;
  private waiting: ShownPicture | undefined;

  /**
   * @param port  port of a worker that has an ImageService
   * @param url   address of the WebSocket, ws://HOST:PORT/images
   * @param name  sheets/{sheet}
   */
  constructor(
    private readonly port: Port<ToImages, FromImages>,
    url: string,
    name: string,
    private readonly events: RemoteImagesEvents,
    options: RemoteImagesOptions,
  ) {
    port.onmessage = ({ data }) => this.receive(data);
    port.postMessage({ kind: 'start', id: this.id, url, name, ...options });
  }

  /** Draws the newest picture and acknowledges it and all before it; false if it was drawn before. */
  draw(paint: (shown: ShownPicture) => void): boolean {
    const shown = this.waiting;
    if (!shown) return false;
    this.waiting = undefined;
    paint(shown);
    shown.picture.close();
    this.port.postMessage({ kind: 'acknowledge', id: this.id, sequence: shown.sequence });
    return true;
  }

  setView(view: ImageView): void {
    this.port.postMessage({ kind: 'view', id: this.id, view });
  }

  setPace(pace: Pace): void {
    this.port.postMessage({ kind: 'pace', id: this.id, pace });
  }

  retryNow(): void {
    this.port.postMessage({ kind: 'retry', id: this.id });
  }

  /** Ends the stream. Pictures and states still in transit are ignored. */
  close(): void {
    this.isClosed = true;
    this.port.postMessage({ kind: 'close', id: this.id });
    this.waiting?.picture.close();
    this.waiting = undefined;
  }

  private receive(message: FromImages): void {
    if (this.isClosed || message.id !== this.id) {
      if (message.kind === 'picture') message.shown.picture.close();
      return;
    }
    switch (message.kind) {
      case 'state':
        this.state = message.state;
        this.detail = message.detail;
        return this.events.onState();
      case 'picture':
        // A picture that was not drawn before the next arrived is skipped.
        this.waiting?.picture.close();
        this.waiting = message.shown;
        return this.events.onPicture(message.shown);
      case 'refused':
        return this.events.onRefused(message.refusal, message.message);
    }
  }
}
