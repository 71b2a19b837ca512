import { ImageCodec } from '../gen/kerf/v1/render_pb';
import type { Image } from '../gen/kerf/v1/render_pb';

/** A picture that can be drawn; its owner must close it. */
export type Picture = VideoFrame | ImageBitmap;

export interface PictureDecoder {
  /**
   * Decodes an image. Pictures arrive in the order of the calls, each with the sequence number of its image.
   * @throws if the image cannot be decoded after those before it
   */
  decode(image: Image): void;
  close(): void;
}

export interface DecoderEvents {
  onPicture(picture: Picture, sequence: number): void;
  /** Called on an error: no picture follows until an image that can be decoded by itself. */
  onError(message: string): void;
}

const kVideoConfig = { codec: 'vp8', optimizeForLatency: true };

/**
 * True if this browser decodes VP8 itself. That needs WebCodecs, which only secure pages (https, this machine) have.
 */
export async function decodesVideo(): Promise<boolean> {
  if (typeof VideoDecoder === 'undefined') return false;
  const answer = await VideoDecoder.isConfigSupported(kVideoConfig).catch(() => undefined);
  return answer?.supported === true;
}

class VideoPictures implements PictureDecoder {
  private decoder: VideoDecoder | undefined;

  constructor(private readonly events: DecoderEvents) {}

  decode({ key, sequence, data }: Image): void {
    this.decoder ??= this.open();
    // The decoder returns the timestamp with the picture, so it carries the sequence number.
    this.decoder.decode(new EncodedVideoChunk({ type: key ? 'key' : 'delta', timestamp: Number(sequence), data }));
  }

  close(): void {
    if (this.decoder?.state !== 'closed') this.decoder?.close();
    this.decoder = undefined;
  }

  private open(): VideoDecoder {
    const decoder = new VideoDecoder({
      output: (frame) => {
        if (decoder === this.decoder) this.events.onPicture(frame, frame.timestamp);
        else frame.close();
      },
      error: ({ message }) => {
        if (decoder !== this.decoder) return;
        this.decoder = undefined;
        this.events.onError(message);
      },
    });
    decoder.configure(kVideoConfig);
    return decoder;
  }
}

class StillPictures implements PictureDecoder {
  private last: Promise<void> = Promise.resolve();
  private isClosed = false;

  constructor(private readonly events: DecoderEvents) {}

  decode({ data, sequence }: Image): void {
    const decoded = createImageBitmap(new Blob([data as Uint8Array<ArrayBuffer>], { type: 'image/jpeg' }));
    this.last = this.last.then(async () => {
      try {
        const picture = await decoded;
        if (this.isClosed) picture.close();
        else this.events.onPicture(picture, Number(sequence));
      } catch (error) {
        if (!this.isClosed) this.events.onError((error as Error).message);
      }
    });
  }

  close(): void {
    this.isClosed = true;
  }
}

/** @param codec  IMAGE_VP8 or IMAGE_JPEG */
export function openDecoder(codec: ImageCodec, events: DecoderEvents): PictureDecoder {
  return codec === ImageCodec.IMAGE_VP8 ? new VideoPictures(events) : new StillPictures(events);
}
