import { Vector3 } from 'three';
import type { LipFinder } from '../geometry/lips';
import type { Surface } from '../geometry/surface';
import { FatLines } from './fat_lines';

/** Highlights the lips of one cut by bright lines, faint where a fold hides them. */
export class LipHighlight {
  private readonly lines = new FatLines({ color: 0x14181f, width: 8, part: 'seen' });
  private find: LipFinder | undefined;
  private edges: Uint32Array = new Uint32Array(0);
  private surface: Surface | undefined;
  private version = -1;

  constructor() {
    this.lines.object.renderOrder = 6;
    this.lines.addLook({ color: 0xffd23f, width: 4.5, part: 'seen' });
    this.lines.addLook({ color: 0xffd23f, width: 4.5, opacity: 0.5, part: 'hidden' });
    this.lines.begin(0);
  }

  get object() {
    return this.lines.object;
  }

  get isOn(): boolean {
    return this.find !== undefined;
  }

  /** @param find  finds the lips to show; undefined: none */
  set(find: LipFinder | undefined): void {
    this.find = find;
    this.version = -1;
  }

  /** Shows the lips where the sheet is now. */
  update(surface: Surface): void {
    if (!this.find) {
      this.lines.begin(0);
      return;
    }
    const { positions, topologyVersion } = surface.mirror;
    if (surface !== this.surface || topologyVersion !== this.version) {
      this.edges = this.find(surface);
      [this.surface, this.version] = [surface, topologyVersion];
    }
    const ends = this.lines.begin(this.edges.length / 2);
    for (let i = 0; i < this.edges.length; ++i) {
      const from = 3 * this.edges[i];
      for (let k = 0; k < 3; ++k) ends[3 * i + k] = positions[from + k];
    }
  }
}

/** Returns the middle of the lips, world, metres; undefined if there are none. */
export function lipCentre(find: LipFinder, surface: Surface): Vector3 | undefined {
  const edges = find(surface);
  const sum = new Vector3();
  const at = new Vector3();
  for (const vertex of edges) sum.add(surface.vertexPosition(vertex, at));
  return edges.length > 0 ? sum.divideScalar(edges.length) : undefined;
}
