import { CutResult_Status } from '../gen/kerf/v1/cuts_pb';
import type { CutResult } from '../gen/kerf/v1/cuts_pb';

/** A small length to two digits, in the unit in which it reads best. */
export function lengthText(metres: number): string {
  if (metres > 0 && metres < 1e-9) return 'under 1 nm';
  const [factor, unit] = metres >= 1e-4 || metres === 0 ? [1e3, 'mm'] : metres >= 1e-7 ? [1e6, 'µm'] : [1e9, 'nm'];
  return `${Number((factor * metres).toPrecision(2))} ${unit}`;
}

export function countText(count: number, one: string, many = `${one}s`): string {
  return `${count.toLocaleString('en')} ${count === 1 ? one : many}`;
}

/** The reply to a cut in a sentence; what the server warns of is not in it. */
export function cutText(result: CutResult): string {
  if (result.status === CutResult_Status.NO_INTERSECTION) {
    return 'Nothing was cut: the line misses the sheet, or follows an older cut';
  }
  const pieces = countText(result.pieces, 'piece');
  const through = result.layers.length > 1 ? ` in ${result.layers.length} stretches` : '';
  const vertices = countText(result.newVertices, 'new vertex', 'new vertices');
  const deviation = lengthText(result.deviationM);
  return `Cut at tick ${result.tick}${through}: ${pieces}, ${vertices}, deviation ${deviation}`;
}

/** What the server warns of, in sentences; empty without any. */
export function warningText({ warnings }: CutResult): string {
  return warnings.map((warning) => `${warning.charAt(0).toUpperCase()}${warning.slice(1)}.`).join(' ');
}
