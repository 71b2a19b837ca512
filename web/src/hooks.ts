import type { App } from './app';
import { ImageCodec } from './gen/kerf/v1/render_pb';
import { meshHash } from './stream/mesh_hash';

/** Of the picture of the server that is shown; undefined while the mesh is drawn here. */
interface PictureHooks {
  readonly tick: number;
  /** Pictures that were shown since the mode was chosen. */
  readonly numShown: number;
  readonly width: number;
  readonly height: number;
  readonly codec: string;
  readonly connection: string;
  /** It is seen from where the page's camera is. */
  readonly isOfView: boolean;
}

/**
 * window.kerf: what the browser test (tests/e2e) reads, and nothing that changes anything. Not an interface for
 * programs: those speak kerf.v1 with the server.
 */
export interface Hooks {
  readonly connection: string;
  readonly sheet: string;
  readonly tick: number;
  readonly topologyVersion: number;
  readonly pieces: number;
  readonly numVertices: number;
  readonly numTriangles: number;
  /** Ticks before the shown frame that were not sent. */
  readonly skipped: number;
  readonly isPaused: boolean;
  readonly isWireframe: boolean;
  readonly isByPiece: boolean;
  /** Number of strains in the shown frame; 0 without. */
  readonly numStrains: number;
  readonly tool: string;
  readonly pinnedVertices: readonly number[];
  readonly framesDrawn: number;
  /** Of the recording that is shown; undefined without. */
  readonly replay: { index: number; numFrames: number; isPlaying: boolean; atMs: number; durationMs: number } | undefined;
  readonly isRecording: boolean;
  readonly picture: PictureHooks | undefined;
  /** See meshHash(); empty before the first frame. */
  readonly meshHash: string;
  /** World position of a material point, metres; undefined before the first frame. */
  toWorld(materialX: number, materialY: number): { x: number; y: number; z: number } | undefined;
  /** The same on the page, CSS pixels. */
  toClient(materialX: number, materialY: number): { x: number; y: number } | undefined;
  /** Id of the piece at a material point; undefined off the sheet and while it is not known. */
  pieceAt(materialX: number, materialY: number): number | undefined;
}

declare global {
  interface Window {
    kerf?: Hooks;
  }
}

export function installHooks(app: App, canvas: HTMLCanvasElement): void {
  const world = (x: number, y: number) => app.surface?.toWorld({ x, y });
  window.kerf = {
    get connection() {
      return app.replayBar.isOpen ? 'replay' : (app.watch?.state ?? 'connecting');
    },
    get sheet() {
      return app.sheetName;
    },
    get tick() {
      return app.surface?.mirror.tick ?? -1;
    },
    get topologyVersion() {
      return app.surface?.mirror.topologyVersion ?? -1;
    },
    get pieces() {
      return app.surface?.mirror.numPieces ?? 0;
    },
    get numVertices() {
      return app.surface?.mirror.numVertices ?? 0;
    },
    get numTriangles() {
      return app.surface?.mirror.stats?.numTriangles ?? 0;
    },
    get skipped() {
      return Number(app.surface?.mirror.stats?.skipped ?? 0);
    },
    get isPaused() {
      return app.surface?.mirror.stats?.paused ?? false;
    },
    get isWireframe() {
      return app.look.isWireframe;
    },
    get numStrains() {
      return app.surface?.mirror.strains?.length ?? 0;
    },
    get isByPiece() {
      return app.look.isByPiece;
    },
    get tool() {
      return app.tool.id;
    },
    get pinnedVertices() {
      return app.sheet?.pinnedVertices ?? [];
    },
    get replay() {
      const { playing } = app.replayBar;
      if (!playing) return undefined;
      const { index, numFrames, isPlaying, atMs, durationMs } = playing;
      return { index, numFrames, isPlaying, atMs, durationMs };
    },
    get isRecording() {
      return app.recording.isOn;
    },
    get picture() {
      const { isShown, tick, numShown, size, codec, state, camera } = app.imageMode;
      if (!isShown) return undefined;
      const { x, y, z } = camera?.eye ?? { x: NaN, y: NaN, z: NaN };
      const isOfView = Math.hypot(...app.stage.camera.position.clone().sub({ x, y, z })) < 1e-9;
      return { tick, numShown, ...size, codec: ImageCodec[codec], connection: state ?? 'none', isOfView };
    },
    get meshHash() {
      return app.surface ? meshHash(app.surface.mirror) : '';
    },
    get framesDrawn() {
      return app.framesDrawn;
    },
    toWorld(x, y) {
      const at = world(x, y);
      return at && { x: at.x, y: at.y, z: at.z };
    },
    pieceAt(x, y) {
      const { surface } = app;
      const place = surface?.locator.find({ x, y });
      return place && app.look.pieceId(surface!.mirror.pieces[place.slot]);
    },
    toClient(x, y) {
      const at = world(x, y);
      const px = at && app.stage.project(at);
      const bounds = canvas.getBoundingClientRect();
      return px && { x: bounds.left + px.x, y: bounds.top + px.y };
    },
  };
}
