import { simplify } from '../geometry/curve';
import type { Point2 } from '../geometry/locator';
import { dashes as dashesOf, stripPolygons } from '../geometry/strip';

// Lines with more chords than this together are simplified.
const kMostChords = 2000;
// Parts of the width that simpler lines may be away from the drawing, until there are few enough chords. Beyond the last
// a strip would no longer cover its lines.
const kStrays = [0.02, 0.1, 0.5];

function numChords(lines: readonly (readonly Point2[])[]): number {
  return lines.reduce((sum, line) => sum + line.length - 1, 0);
}

/**
 * The strip that a cut along these lines takes away: polygons that may overlap.
 *
 * @param width    in the lines' unit; 0: it takes nothing
 * @param lengths  of dashes, that are cut and left in turn; none: all of it is cut
 */
export function stripAlong(lines: readonly (readonly Point2[])[], width: number, lengths: readonly number[]): Point2[][] {
  if (width === 0) return [];
  const drawn = dashesOf(lines, lengths);
  let shown = drawn;
  for (const stray of kStrays) {
    if (numChords(shown) <= kMostChords) break;
    shown = drawn.map((line) => simplify(line, stray * width));
  }
  return shown.flatMap((line) => stripPolygons(line, width));
}
