import { simplify } from '../geometry/curve';
import type { Point2 } from '../geometry/locator';
import { dashes as dashesOf, stripPolygons } from '../geometry/strip';

// Lines that together have more chords than this are simplified.
const kMostChords = 2000;
// Largest distances of simplified lines from the drawing, as shares of the width, tried in turn until there are few
// enough chords. Beyond 0.5 the strip would no longer cover the lines.
const kStrays = [0.02, 0.1, 0.5];

function numChords(lines: readonly (readonly Point2[])[]): number {
  return lines.reduce((sum, line) => sum + line.length - 1, 0);
}

/**
 * Returns the strip that a cut along these lines removes, as polygons that may overlap.
 *
 * @param width    in the lines' unit; 0: nothing is removed
 * @param lengths  lengths cut and left in turn; empty: everything is cut
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
