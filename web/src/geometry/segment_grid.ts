import type { Point2 } from './locator';

/** Returns the chords of polylines as x, y of start and end, 4 numbers each. */
export function chordsOf(lines: readonly (readonly Point2[])[]): Float64Array {
  const numbers: number[] = [];
  for (const line of lines) {
    for (let i = 0; i + 1 < line.length; ++i) numbers.push(line[i].x, line[i].y, line[i + 1].x, line[i + 1].y);
  }
  return Float64Array.from(numbers);
}

/** Finds out if points lie within a distance of any of many segments, by a grid of the segments. */
export class SegmentGrid {
  private readonly cells = new Map<string, number[]>();
  private readonly side: number;

  /**
   * @param segments  x, y of start and end, 4 numbers each
   * @param reach     distance within which a point counts as on a segment, > 0
   */
  constructor(
    private readonly segments: Float64Array,
    private readonly reach: number,
  ) {
    let total = 0;
    const count = segments.length / 4;
    for (let i = 0; i < segments.length; i += 4) {
      total += Math.hypot(segments[i + 2] - segments[i], segments[i + 3] - segments[i + 1]);
    }
    this.side = Math.max(4 * reach, total / Math.max(1, count));
    for (let i = 0; i < segments.length; i += 4) {
      this.eachCell(segments[i], segments[i + 1], segments[i + 2], segments[i + 3], (key) => {
        const cell = this.cells.get(key);
        if (cell) cell.push(i);
        else this.cells.set(key, [i]);
      });
    }
  }

  /** True if the point is within reach of a segment. */
  has(x: number, y: number): boolean {
    const cell = this.cells.get(`${Math.floor(x / this.side)} ${Math.floor(y / this.side)}`);
    return cell?.some((i) => this.isNear(x, y, i)) ?? false;
  }

  private isNear(x: number, y: number, i: number): boolean {
    const [ax, ay, bx, by] = this.segments.subarray(i, i + 4);
    const [dx, dy] = [bx - ax, by - ay];
    const t = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
    return Math.hypot(x - ax - t * dx, y - ay - t * dy) <= this.reach;
  }

  // Visits the cells of a segment's box, widened by the reach; long segments are divided, so that few cells are visited.
  private eachCell(ax: number, ay: number, bx: number, by: number, visit: (key: string) => void): void {
    const parts = Math.max(1, Math.ceil(Math.hypot(bx - ax, by - ay) / this.side));
    const seen = new Set<string>();
    for (let part = 0; part < parts; ++part) {
      const [x0, y0] = [ax + ((bx - ax) * part) / parts, ay + ((by - ay) * part) / parts];
      const [x1, y1] = [ax + ((bx - ax) * (part + 1)) / parts, ay + ((by - ay) * (part + 1)) / parts];
      const cell = (at: number) => Math.floor(at / this.side);
      for (let i = cell(Math.min(x0, x1) - this.reach); i <= cell(Math.max(x0, x1) + this.reach); ++i) {
        for (let j = cell(Math.min(y0, y1) - this.reach); j <= cell(Math.max(y0, y1) + this.reach); ++j) seen.add(`${i} ${j}`);
      }
    }
    seen.forEach(visit);
  }
}
