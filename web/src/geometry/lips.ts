import type { Cut } from '../gen/kerf/v1/scene_pb';
import { curveLines } from './curve_lines';
import { SegmentGrid, chordsOf } from './segment_grid';
import type { Surface } from './surface';

/** Returns the lips of one cut on a sheet, as start and end vertex of each edge. */
export type LipFinder = (surface: Surface) => Uint32Array;

// Material positions are in single precision; a point is on a line within this share of the sheet's larger side.
const kOnLine = 1e-5;
// Most versions that are kept.
const kMostVersions = 1000;

function sizeOf({ locator: { min, max } }: Surface): number {
  return Math.max(max.x - min.x, max.y - min.y);
}

// Both ends and the middle are compared, because an edge may join two older lips.
function isEdgeOn({ mirror: { materialPositions: m } }: Surface, a: number, b: number, grid: SegmentGrid): boolean {
  const [ax, ay, bx, by] = [m[2 * a], m[2 * a + 1], m[2 * b], m[2 * b + 1]];
  return grid.has(0.5 * (ax + bx), 0.5 * (ay + by)) && grid.has(ax, ay) && grid.has(bx, by);
}

// Returns a finder of those edges of border and lips that lie on these segments.
function finderOf(segments: Float64Array, reach: (surface: Surface) => number): LipFinder {
  let grid: SegmentGrid | undefined;
  return (surface) => {
    grid ??= new SegmentGrid(segments, reach(surface));
    const { boundary } = surface;
    const edges: number[] = [];
    for (let i = 0; i < boundary.length; i += 3) {
      if (isEdgeOn(surface, boundary[i], boundary[i + 1], grid)) edges.push(boundary[i], boundary[i + 1]);
    }
    return Uint32Array.from(edges);
  };
}

/**
 * Returns a finder of the lips of a cut that was made in material coordinates; undefined if its curve is given otherwise.
 * @param deviationM  CutResult.deviation_m
 */
export function lipsAlong(cut: Cut, deviationM: number): LipFinder | undefined {
  if (!cut.curve || cut.view || cut.fit) return undefined;
  const chords = chordsOf(curveLines(cut.curve, Math.max(1e-6, deviationM)));
  if (chords.length === 0) return undefined;
  return finderOf(chords, (surface) => 0.5 * cut.widthM + 2 * deviationM + kOnLine * sizeOf(surface));
}

/**
 * Remembers which lips appeared with which topology version, in material coordinates. So the lips of a cut that was drawn
 * on a picture are known, if this page watched the sheet when it was made.
 */
export class LipRecord {
  private epoch = '';
  private version = -1;
  private border: SegmentGrid | undefined;
  private made: { after: number; version: number; segments: Float64Array }[] = [];

  /** Call it with each state of the sheet; cheap if its topology has not changed. */
  see(surface: Surface): void {
    const { epoch, topologyVersion } = surface.mirror;
    const isSame = epoch === this.epoch && topologyVersion >= this.version && this.border !== undefined;
    if (isSame && topologyVersion === this.version) return;
    if (!isSame) this.made = [];
    else this.compare(surface, this.border!);
    this.border = new SegmentGrid(segmentsOf(surface, () => true), kOnLine * sizeOf(surface));
    [this.epoch, this.version] = [epoch, topologyVersion];
  }

  /** Returns a finder of the lips that appeared with this version; undefined if that was not seen. */
  at(version: number): LipFinder | undefined {
    const found = this.made.find((each) => each.after < version && version <= each.version);
    return found && finderOf(found.segments, (surface) => kOnLine * sizeOf(surface));
  }

  private compare(surface: Surface, before: SegmentGrid): void {
    const segments = segmentsOf(surface, (a, b) => !isEdgeOn(surface, a, b, before));
    if (segments.length === 0) return;
    this.made.push({ after: this.version, version: surface.mirror.topologyVersion, segments });
    if (this.made.length > kMostVersions) this.made.shift();
  }
}

function segmentsOf(surface: Surface, isWanted: (a: number, b: number) => boolean): Float64Array {
  const {
    boundary,
    mirror: { materialPositions: m },
  } = surface;
  const numbers: number[] = [];
  for (let i = 0; i < boundary.length; i += 3) {
    const [a, b] = [boundary[i], boundary[i + 1]];
    if (isWanted(a, b)) numbers.push(m[2 * a], m[2 * a + 1], m[2 * b], m[2 * b + 1]);
  }
  return Float64Array.from(numbers);
}
