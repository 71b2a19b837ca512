import type { Point2 } from './locator';

// Number of a line's points that are tested for being inside another line; a single one may lie on that line.
const kProbes = 16;
/** Most holes that the server accepts. */
export const kMaxHoles = 1024;

type Line = readonly Point2[];

/**
 * Returns the index of the closed line that is the border of a sheet with the others as holes: the one around the
 * largest area. Lines that cross are not found here; the server refuses them.
 * @throws Error with a text for people, if lines are no holes inside the border or are too many
 */
export function borderOf(lines: readonly Line[]): number {
  if (lines.length - 1 > kMaxHoles) {
    const [holes, limit] = [lines.length - 1, kMaxHoles].map((count) => count.toLocaleString('en'));
    throw new Error(`has ${holes} lines besides its border, but a sheet has at most ${limit} holes: remove some`);
  }
  const areas = lines.map(area);
  const border = areas.indexOf(Math.max(...areas));
  const holes = lines.filter((_, i) => i !== border).map((line) => new Region(line));
  const outer = new Region(lines[border]);
  if (!holes.every((hole) => outer.surrounds(hole))) {
    throw new Error('has lines outside of its largest one, which is the border: move them into it, or remove them');
  }
  if (holes.some((hole) => holes.some((other) => other !== hole && other.surrounds(hole)))) {
    throw new Error('has lines inside a hole, where nothing is left to cut: remove the inner ones');
  }
  return border;
}

function area(line: Line): number {
  let doubled = 0;
  for (let i = 0, before = line.length - 1; i < line.length; before = i++) {
    doubled += line[before].x * line[i].y - line[i].x * line[before].y;
  }
  return 0.5 * Math.abs(doubled);
}

class Region {
  private readonly min: Point2 = { x: Infinity, y: Infinity };
  private readonly max: Point2 = { x: -Infinity, y: -Infinity };

  constructor(private readonly line: Line) {
    for (const { x, y } of line) {
      [this.min.x, this.max.x] = [Math.min(this.min.x, x), Math.max(this.max.x, x)];
      [this.min.y, this.max.y] = [Math.min(this.min.y, y), Math.max(this.max.y, y)];
    }
  }

  surrounds({ line }: Region): boolean {
    const step = Math.max(1, Math.floor(line.length / kProbes));
    const probes = line.filter((_, i) => i % step === 0);
    return 2 * probes.filter((probe) => this.contains(probe)).length > probes.length;
  }

  // Tests a point by the even-odd rule.
  private contains({ x, y }: Point2): boolean {
    if (x < this.min.x || x > this.max.x || y < this.min.y || y > this.max.y) return false;
    let isInside = false;
    for (let i = 0, before = this.line.length - 1; i < this.line.length; before = i++) {
      const [a, b] = [this.line[before], this.line[i]];
      if (a.y > y !== b.y > y && x < a.x + ((y - a.y) / (b.y - a.y)) * (b.x - a.x)) isInside = !isInside;
    }
    return isInside;
  }
}
