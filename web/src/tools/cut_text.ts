import { CutResult_Status } from '../gen/kerf/v1/cuts_pb';
import type { CutResult } from '../gen/kerf/v1/cuts_pb';

/** A small length to two digits, in the unit in which it reads best. */
export function lengthText(metres: number): string {
  if (metres > 0 && metres < 1e-9) return 'under 1 nm';
  const [factor, unit] = metres >= 1e-4 || metres === 0 ? [1e3, 'mm'] : metres >= 1e-7 ? [1e6, 'µm'] : [1e9, 'nm'];
  return `${Number((factor * metres).toPrecision(2))} ${unit}`;
}

/** The reply to a cut in a sentence. */
export function cutText(result: CutResult): string {
  if (result.status === CutResult_Status.NO_INTERSECTION) return 'The curve does not meet the sheet: nothing was cut';
  const pieces = `${result.pieces} ${result.pieces === 1 ? 'piece' : 'pieces'}`;
  const text =
    `Cut at tick ${result.tick}: ${pieces}, ${result.newVertices} new vertices, ` +
    `deviation ${lengthText(result.deviationM)}`;
  return [text, ...result.warnings].join('. ');
}
