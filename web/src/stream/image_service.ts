import type { FromImages, ToImages } from './image_messages';
import { ImageWatch } from './image_watch';
import type { ImageWatchEvents } from './image_watch';
import type { openDecoder } from './picture_decoder';
import type { Port } from './watch_messages';

/** The worker's side of a stream of pictures: holds the connection and decodes the pictures. */
export class ImageService {
  private watch: ImageWatch | undefined;
  private id = 0;

  constructor(
    private readonly page: Port<FromImages, ToImages>,
    private readonly makeDecoder: typeof openDecoder,
  ) {
    page.onmessage = ({ data }) => this.receive(data);
  }

  private receive(message: ToImages): void {
    if (message.kind === 'start') return this.start(message);
    if (message.id !== this.id) return;
    switch (message.kind) {
      case 'view':
        return this.watch?.setView(message.view);
      case 'pace':
        return this.watch?.setPace(message.pace);
      case 'acknowledge':
        return this.watch?.acknowledge(message.sequence);
      case 'retry':
        return this.watch?.retryNow();
      case 'close':
        return this.watch?.close();
    }
  }

  private start({ id, url, name, codec, view, pace }: ToImages & { kind: 'start' }): void {
    this.watch?.close();
    this.id = id;
    const events: ImageWatchEvents = {
      onState: (state, detail) => this.page.postMessage({ kind: 'state', id, state, detail }),
      onPicture: (shown) => this.page.postMessage({ kind: 'picture', id, shown }, [shown.picture]),
      onRefused: (refusal, message) => this.page.postMessage({ kind: 'refused', id, refusal, message }),
    };
    this.watch = new ImageWatch(url, name, codec, view, events, this.makeDecoder);
    this.watch.setPace(pace);
  }
}
