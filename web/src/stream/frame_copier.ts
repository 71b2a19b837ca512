import { unixTimeMs } from './frame_clock';
import type { SheetMirror } from './mirror';
import type { FrameCopy, TopologyCopy } from './sheet_copy';
import { SpareArrays } from './spare_arrays';
import type { Delivery } from './stream_meter';

/** Copies a mirror's state in a worker, to be sent to the page. */
export class FrameCopier {
  readonly spare = new SpareArrays();
  private shownTriangles: Int32Array | undefined;

  /**
   * @param isFirst  the page has no frame yet, so the copy includes the topology even if it is not new
   * @returns the copy, and its buffers to be transferred
   */
  copy(mirror: SheetMirror, delivery: Delivery, isFirst: boolean): { frame: FrameCopy; buffers: ArrayBuffer[] } {
    // A frame with a new topology gives the mirror new arrays.
    const topology = isFirst || mirror.triangles !== this.shownTriangles ? topologyOf(mirror) : undefined;
    this.shownTriangles = mirror.triangles;
    const frame: FrameCopy = {
      epoch: mirror.epoch,
      tick: mirror.tick,
      topologyVersion: mirror.topologyVersion,
      numSlots: mirror.numSlots,
      numPieces: mirror.numPieces,
      positions: this.spare.copyOf(mirror.positions, 3 * mirror.numVertices),
      strains: mirror.strains && this.spare.copyOf(mirror.strains, mirror.strains.length),
      probeValues: mirror.probeValues,
      probeColumns: isFirst ? mirror.probeColumns : undefined,
      stats: mirror.stats,
      arrivedMs: unixTimeMs(),
      topology,
      delivery,
    };
    const arrays = [frame.positions, frame.strains, topology?.triangles, topology?.pieces, topology?.materialPositions];
    const buffers = arrays.filter((array) => array !== undefined).map((array) => array.buffer as ArrayBuffer);
    return { frame, buffers };
  }
}

function topologyOf(mirror: SheetMirror): TopologyCopy {
  return {
    triangles: mirror.triangles.slice(0, 3 * mirror.numSlots),
    pieces: mirror.pieces.slice(0, mirror.numSlots),
    materialPositions: mirror.materialPositions.slice(0, 2 * mirror.numVertices),
  };
}
