import type { Point2 } from '../geometry/locator';
import { dashes as dashesOf, stripPolygons } from '../geometry/strip';

// Lines with more chords than this lose points, evenly.
const kMaxChords = 2000;

/**
 * The strip that a cut along these lines takes away: polygons that may overlap.
 *
 * @param width    in the lines' unit; 0: it takes nothing
 * @param lengths  of dashes, that are cut and left in turn; none: all of it is cut
 */
export function stripAlong(lines: readonly (readonly Point2[])[], width: number, lengths: readonly number[]): Point2[][] {
  if (width === 0) return [];
  const chords = lines.reduce((sum, line) => sum + line.length, 0);
  const step = Math.ceil(chords / kMaxChords);
  const thinned = lines.map((line) => line.filter((_, i) => i % step === 0 || i === line.length - 1));
  return dashesOf(thinned, lengths).flatMap((dash) => stripPolygons(dash, width));
}
