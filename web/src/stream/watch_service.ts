import { unixTimeMs } from './frame_clock';
import type { SheetMirror } from './mirror';
import type { FrameCopy, TopologyCopy } from './sheet_copy';
import { Watch } from './watch';
import type { FromWorker, Port, ToWorker } from './watch_messages';

/**
 * The worker's side: holds the connection, decodes frames and hands copies of them to the page, which draws meanwhile. The
 * server sends no more than the page acknowledges, so none are queued between the two.
 */
export class WatchService {
  private watch: Watch | undefined;
  private id = 0;
  private name = '';
  private shown: SheetMirror | undefined;
  private shownVersion = -1;

  constructor(private readonly page: Port<FromWorker, ToWorker>) {
    page.onmessage = ({ data }) => this.receive(data);
  }

  private receive(message: ToWorker): void {
    if (message.kind === 'start') return this.start(message);
    if (message.id !== this.id) return;
    switch (message.kind) {
      case 'acknowledge':
        return this.watch?.acknowledge();
      case 'send':
        this.watch?.send(message.request);
        return;
      case 'pause':
        return this.watch?.setPaused(message.isPaused);
      case 'retry':
        return this.watch?.retryNow();
      case 'close':
        return this.watch?.close();
    }
  }

  private start({ id, url, name, strains, goesOn, isPaused }: ToWorker & { kind: 'start' }): void {
    const from = goesOn && name === this.name ? this.watch?.mirror : undefined;
    this.watch?.close();
    this.id = id;
    this.name = name;
    this.shown = undefined;
    const events = {
      onState: (state: 'connecting' | 'live' | 'lost' | 'ended', detail: string) =>
        this.post({ kind: 'state', id, state, detail }),
      onFrame: (mirror: SheetMirror) => this.handOn(id, mirror),
      onRejection: (rejection: (FromWorker & { kind: 'rejection' })['rejection']) =>
        this.post({ kind: 'rejection', id, rejection }),
    };
    this.watch = new Watch(url, name, events, { strains, from });
    this.watch.setPaused(isPaused);
  }

  private handOn(id: number, mirror: SheetMirror): void {
    const isFirst = mirror !== this.shown;
    const topology = isFirst || mirror.topologyVersion !== this.shownVersion ? topologyOf(mirror) : undefined;
    this.shown = mirror;
    this.shownVersion = mirror.topologyVersion;
    const frame: FrameCopy = {
      tick: mirror.tick,
      topologyVersion: mirror.topologyVersion,
      numSlots: mirror.numSlots,
      numPieces: mirror.numPieces,
      positions: mirror.positions.slice(0, 3 * mirror.numVertices),
      strains: mirror.strains?.slice(),
      stats: mirror.stats,
      arrivedMs: unixTimeMs(),
      topology,
    };
    const arrays = [frame.positions, frame.strains, topology?.triangles, topology?.pieces, topology?.materialPositions];
    this.post(
      { kind: 'frame', id, frame, isFirst },
      arrays.filter((array) => array !== undefined).map((array) => array.buffer as ArrayBuffer),
    );
  }

  private post(message: FromWorker, transfer: Transferable[] = []): void {
    this.page.postMessage(message, transfer);
  }
}

function topologyOf(mirror: SheetMirror): TopologyCopy {
  return {
    triangles: mirror.triangles.slice(0, 3 * mirror.numSlots),
    pieces: mirror.pieces.slice(0, mirror.numSlots),
    materialPositions: mirror.materialPositions.slice(0, 2 * mirror.numVertices),
  };
}
