import { ImageCodec } from './gen/kerf/v1/render_pb';
import type { Stage } from './scene/stage';
import type { OpenSheet, ShownState } from './sheet/open_sheet';
import { meshHash } from './stream/mesh_hash';
import type { Replay } from './stream/replay';
import type { ImageMode } from './ui/image_mode';
import type { SheetLook } from './ui/sheet_look';

/** The parts of the viewer that the hooks read. */
export interface HookedParts {
  readonly live: Pick<OpenSheet, 'sheetName'> & { readonly watch: { readonly state: string } | undefined };
  readonly shown: ShownState;
  readonly stage: Pick<Stage, 'camera' | 'project'>;
  readonly look: Pick<SheetLook, 'isWireframe' | 'isByPiece' | 'pieceId'>;
  readonly tools: { readonly tool: { readonly id: string } };
  readonly replayBar: { readonly isOpen: boolean; readonly playing: Replay | undefined };
  readonly recording: { readonly isOn: boolean };
  readonly imageMode: Pick<ImageMode, 'isShown' | 'tick' | 'numShown' | 'size' | 'codec' | 'state' | 'camera'>;
  readonly loop: { readonly framesDrawn: number };
}

/** The server's picture that is shown. */
interface PictureHooks {
  readonly tick: number;
  /** Number of pictures shown since the user chose pictures of the server. */
  readonly numShown: number;
  readonly width: number;
  readonly height: number;
  readonly codec: string;
  readonly connection: string;
  /** True if the picture was drawn from the page's present camera. */
  readonly isOfView: boolean;
}

/**
 * window.kerf, a read-only view for the browser test (tests/e2e). It is no interface for programs, which should call
 * kerf.v1 of the server.
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
  /** Number of strains in the shown frame; 0 if it has none. */
  readonly numStrains: number;
  readonly tool: string;
  readonly pinnedVertices: readonly number[];
  readonly framesDrawn: number;
  /** The recording that is shown; undefined while a live sheet is shown. */
  readonly replay: { index: number; numFrames: number; isPlaying: boolean; atMs: number; durationMs: number } | undefined;
  readonly isRecording: boolean;
  /** Undefined while the page draws the mesh itself. */
  readonly picture: PictureHooks | undefined;
  /** See meshHash(); empty before the first frame. */
  readonly meshHash: string;
  /** World position of a material point, metres; undefined before the first frame. */
  toWorld(materialX: number, materialY: number): { x: number; y: number; z: number } | undefined;
  /** Position of a material point on the page, CSS pixels; undefined behind the camera and before the first frame. */
  toClient(materialX: number, materialY: number): { x: number; y: number } | undefined;
  /** Id of the piece at a material point; undefined off the sheet and while the id is not known. */
  pieceAt(materialX: number, materialY: number): number | undefined;
}

declare global {
  interface Window {
    kerf?: Hooks;
  }
}

export function installHooks(parts: HookedParts, canvas: HTMLCanvasElement): void {
  const world = (x: number, y: number) => parts.shown.surface?.toWorld({ x, y });
  window.kerf = {
    get connection() {
      return parts.replayBar.isOpen ? 'replay' : (parts.live.watch?.state ?? 'connecting');
    },
    get sheet() {
      return parts.live.sheetName;
    },
    get tick() {
      return parts.shown.surface?.mirror.tick ?? -1;
    },
    get topologyVersion() {
      return parts.shown.surface?.mirror.topologyVersion ?? -1;
    },
    get pieces() {
      return parts.shown.surface?.mirror.numPieces ?? 0;
    },
    get numVertices() {
      return parts.shown.surface?.mirror.numVertices ?? 0;
    },
    get numTriangles() {
      return parts.shown.surface?.mirror.stats?.numTriangles ?? 0;
    },
    get skipped() {
      return Number(parts.shown.surface?.mirror.stats?.skipped ?? 0);
    },
    get isPaused() {
      return parts.shown.surface?.mirror.stats?.paused ?? false;
    },
    get isWireframe() {
      return parts.look.isWireframe;
    },
    get numStrains() {
      return parts.shown.surface?.mirror.strains?.length ?? 0;
    },
    get isByPiece() {
      return parts.look.isByPiece;
    },
    get tool() {
      return parts.tools.tool.id;
    },
    get pinnedVertices() {
      return parts.shown.sheet?.pinnedVertices ?? [];
    },
    get replay() {
      const { playing } = parts.replayBar;
      if (!playing) return undefined;
      const { index, numFrames, isPlaying, atMs, durationMs } = playing;
      return { index, numFrames, isPlaying, atMs, durationMs };
    },
    get isRecording() {
      return parts.recording.isOn;
    },
    get picture() {
      const { isShown, tick, numShown, size, codec, state, camera } = parts.imageMode;
      if (!isShown) return undefined;
      const { x, y, z } = camera?.eye ?? { x: NaN, y: NaN, z: NaN };
      const isOfView = Math.hypot(...parts.stage.camera.position.clone().sub({ x, y, z })) < 1e-9;
      return { tick, numShown, ...size, codec: ImageCodec[codec], connection: state ?? 'none', isOfView };
    },
    get meshHash() {
      return parts.shown.surface ? meshHash(parts.shown.surface.mirror) : '';
    },
    get framesDrawn() {
      return parts.loop.framesDrawn;
    },
    toWorld(x, y) {
      const at = world(x, y);
      return at && { x: at.x, y: at.y, z: at.z };
    },
    pieceAt(x, y) {
      const { surface } = parts.shown;
      const place = surface?.locator.find({ x, y });
      return place && parts.look.pieceId(surface!.mirror.pieces[place.slot]);
    },
    toClient(x, y) {
      const at = world(x, y);
      const px = at && parts.stage.project(at);
      const bounds = canvas.getBoundingClientRect();
      return px && { x: bounds.left + px.x, y: bounds.top + px.y };
    },
  };
}
