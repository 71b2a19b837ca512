import type { Camera } from '../gen/kerf/v1/geometry_pb';
import { ColorBy, ImageCodec } from '../gen/kerf/v1/render_pb';
import type { FrameStats } from '../gen/kerf/v1/stream_pb';
import type { Notifier } from '../notifier';
import { pictureSize, pictureView } from '../scene/picture_view';
import type { Stage } from '../scene/stage';
import type { OpenSheet } from '../sheet/open_sheet';
import type { ConnectionState } from '../stream/connection';
import { FrameClock, unixTimeMs } from '../stream/frame_clock';
import type { ImageView, Refusal, ShownPicture } from '../stream/image_watch';
import { decodesVideo } from '../stream/picture_decoder';
import { RemoteImages } from '../stream/remote_images';
import type { SheetFigures } from '../stream/sheet_copy';
import { streamUrl } from '../stream/stream_url';
import type { Pace } from '../stream/watch';
import { startWorker } from '../stream/workers';
import { element } from './dom';
import type { SheetLook } from './sheet_look';
import type { StatisticsPanel } from './statistics_panel';
import type { StrainScale } from './strain_scale';

// Rates of the mesh's frames while pictures are shown: while tools need places on the mesh, and otherwise, for figures
// only.
const kPickingRateHz = 10;
const kIdleRateHz = 1;

/** The parts of the viewer that pictures depend on. */
export interface PictureParts {
  readonly live: Pick<OpenSheet, 'sheetName'> & { readonly isWatched: boolean };
  readonly stage: Pick<Stage, 'backdrop' | 'camera' | 'controls' | 'sizePx'>;
  readonly look: Pick<SheetLook, 'isByPiece' | 'isByStrain' | 'isWireframe'> & {
    readonly strainScale: Pick<StrainScale, 'show'>;
  };
  readonly theme: { readonly isDark: boolean };
  readonly statistics: Pick<StatisticsPanel, 'arrived' | 'reset'>;
  readonly notices: Notifier;
  /** True if a tool or a panel needs places on the mesh. */
  isPicking(): boolean;
  /** Called when the state of the pictures' connection has changed. */
  showConnections(): void;
  /** Sets whether the page draws the mesh; otherwise the server's picture shows it. */
  setMeshDrawn(isDrawn: boolean): void;
}

/**
 * Shows the sheet in pictures drawn by the server, in place of the mesh drawn by the page. Frames of the mesh still
 * come, at a low rate, so that tools can pick from it. Tools and pins are drawn over the picture.
 */
export class ImageMode {
  /** Tick of the shown picture; -1 before the first. */
  tick = -1;
  /** Number of pictures shown since the mode was chosen. */
  numShown = 0;
  codec = ImageCodec.IMAGE_CODEC_UNSPECIFIED;
  /** Camera of the shown picture. */
  camera: Camera | undefined;

  private readonly canvas = element<HTMLCanvasElement>('picture');
  private readonly context = this.canvas.getContext('2d')!;
  private readonly button = element('image-mode');
  private worker: Worker | undefined;
  private images: RemoteImages | undefined;
  private clock = new FrameClock();
  private stats: FrameStats | undefined;
  private sentView = '';
  private canVideo: boolean | undefined;
  private isChosen = false;

  constructor(private readonly parts: PictureParts) {}

  get isOn(): boolean {
    return this.isChosen;
  }

  /** True if a picture is shown in place of the mesh, from the first picture on. */
  get isShown(): boolean {
    return !this.canvas.hidden;
  }

  get state(): ConnectionState | undefined {
    return this.images?.state;
  }

  /** State of the pictures' connection, with the reason; undefined while all is well. */
  get trouble(): { state: ConnectionState; detail: string } | undefined {
    const { images } = this;
    if (!images || images.detail === '') return undefined;
    return { state: images.state, detail: `No pictures: ${images.detail}` };
  }

  /**
   * Age of the shown picture's tick, milliseconds; undefined if the sheet does not move or the connection is not live.
   */
  get ageMs(): number | undefined {
    const isMoving = this.stats !== undefined && !this.stats.paused && !this.stats.sleeping;
    return isMoving && this.state === 'live' ? this.clock.ageMs(unixTimeMs()) : undefined;
  }

  /** Codec and size, for people. */
  get format(): string {
    const { width, height } = this.canvas;
    return `${this.codec === ImageCodec.IMAGE_VP8 ? 'VP8' : 'JPEG'}, ${width} × ${height}`;
  }

  get size(): { width: number; height: number } {
    return { width: this.canvas.width, height: this.canvas.height };
  }

  /** Rate of the mesh's frames while pictures are shown. */
  get meshRateHz(): number {
    return this.parts.isPicking() ? kPickingRateHz : kIdleRateHz;
  }

  /** Returns figures of the sheet at the picture's tick; the number of vertices is the mesh's. */
  figures({ numVertices }: SheetFigures): SheetFigures {
    const { tick, stats } = this;
    return { tick, numVertices, numPieces: stats?.pieces ?? 0, stats };
  }

  async toggle(): Promise<void> {
    if (this.isChosen) {
      this.leave();
      return;
    }
    if (!this.parts.live.isWatched) {
      this.parts.notices.notify('info', 'The server draws pictures of live sheets only');
      return;
    }
    this.setChosen(true);
    this.canVideo ??= await decodesVideo();
    // In the meantime the mode may have been left, or may already follow another sheet.
    if (this.parts.live.isWatched && !this.images) this.follow();
  }

  leave(): void {
    if (!this.isChosen) return;
    this.close();
    this.setChosen(false);
    this.setShown(false);
  }

  /** Starts pictures of the live sheet, if the mode is chosen. */
  follow(): void {
    if (!this.isChosen || this.canVideo === undefined) return;
    this.close();
    this.worker ??= startWorker('images', (why) => this.failed(why));
    this.codec = this.canVideo ? ImageCodec.IMAGE_VP8 : ImageCodec.IMAGE_JPEG;
    const view = this.view();
    this.sentView = JSON.stringify(view);
    const events = {
      onState: () => this.parts.showConnections(),
      onPicture: (shown: ShownPicture) => this.parts.statistics.arrived(shown.delivery, shown.stats),
      onRefused: (refusal: Refusal, message: string) => this.refused(refusal, message),
    };
    const options = { codec: this.codec, view, pace: this.pace };
    this.images = new RemoteImages(this.worker, streamUrl('images'), this.parts.live.sheetName, events, options);
  }

  /** Ends the stream of pictures; the last one stays visible. */
  close(): void {
    this.images?.close();
    this.images = undefined;
    this.clock = new FrameClock();
    this.stats = undefined;
  }

  /** Hides the last picture until the next arrives. */
  clear(): void {
    this.tick = -1;
    if (this.isShown) this.setShown(false);
  }

  /** Call it when the page was shown or hidden. */
  pageSeen(): void {
    this.images?.setPace(this.pace);
    if (!document.hidden) this.images?.retryNow();
  }

  /** Requests pictures of the camera's present view if that has changed. */
  look(): void {
    if (!this.images) return;
    const view = this.view();
    const text = JSON.stringify(view);
    if (text === this.sentView) return;
    this.sentView = text;
    this.images.setView(view);
  }

  /** Draws the newest picture; false if it was drawn before. */
  draw(): boolean {
    return this.images?.draw((shown) => this.paint(shown)) ?? false;
  }

  private paint({ picture, tick, stats, camera, strainEnd, arrivedMs }: ShownPicture): void {
    const { canvas } = this;
    const [width, height] =
      picture instanceof ImageBitmap ? [picture.width, picture.height] : [picture.displayWidth, picture.displayHeight];
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    this.context.drawImage(picture, 0, 0);
    if (stats) this.clock.arrived(stats.publishedUnixUs, arrivedMs);
    this.tick = tick;
    this.stats = stats;
    this.camera = camera;
    this.numShown += 1;
    if (!this.isShown) this.setShown(true);
    if (strainEnd > 0) this.parts.look.strainScale.show(strainEnd);
  }

  private setChosen(isChosen: boolean): void {
    this.isChosen = isChosen;
    this.numShown = 0;
    this.tick = -1;
    this.button.setAttribute('aria-pressed', String(isChosen));
    this.parts.statistics.reset();
    this.parts.showConnections();
  }

  private setShown(isShown: boolean): void {
    this.canvas.hidden = !isShown;
    this.parts.stage.backdrop = isShown ? this.canvas : undefined;
    this.parts.setMeshDrawn(!isShown);
  }

  // Tries JPEG if VP8 fails; if the server has no renderer, there are no pictures.
  private refused(refusal: Refusal, message: string): void {
    if (refusal !== 'RENDERER_UNAVAILABLE' && this.codec === ImageCodec.IMAGE_VP8) {
      this.canVideo = false;
      this.follow();
      return;
    }
    this.giveUp(message);
  }

  private failed(why: string): void {
    this.worker = undefined;
    if (!this.isChosen) return;
    this.giveUp(`the decoder failed: ${why}`);
  }

  private giveUp(why: string): void {
    this.leave();
    this.parts.notices.notify('error', `No pictures, so the mesh is shown: ${why}`);
  }

  private get pace(): Pace {
    return { isPaused: document.hidden, maxRateHz: 0 };
  }

  private view(): ImageView {
    const { stage, look, theme } = this.parts;
    const colorBy = look.isByPiece ? ColorBy.PIECES : look.isByStrain ? ColorBy.STRAINS : ColorBy.SIDES;
    const size = pictureSize(stage.sizePx, Math.min(devicePixelRatio, 2));
    const wanted = { wireframe: look.isWireframe, colorBy, dark: theme.isDark };
    return pictureView(stage.camera, stage.controls.target, size, wanted);
  }
}
