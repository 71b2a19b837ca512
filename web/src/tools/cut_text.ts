import { CutResult_Status } from '../gen/kerf/v1/cuts_pb';
import type { CutResult } from '../gen/kerf/v1/cuts_pb';

/** Formats a small length with two digits, in a suitable unit. */
export function lengthText(metres: number): string {
  if (metres > 0 && metres < 1e-9) return 'under 1 nm';
  const [factor, unit] = metres >= 1e-4 || metres === 0 ? [1e3, 'mm'] : metres >= 1e-7 ? [1e6, 'µm'] : [1e9, 'nm'];
  return `${Number((factor * metres).toPrecision(2))} ${unit}`;
}

export function countText(count: number, one: string, many = `${one}s`): string {
  return `${count.toLocaleString('en')} ${count === 1 ? one : many}`;
}

/** Formats an area with two digits, in a suitable unit. */
export function areaText(squareMetres: number): string {
  const units: [number, string][] = [[1, 'm²'], [1e4, 'cm²'], [1e6, 'mm²'], [1e12, 'µm²']];
  return inUnit(squareMetres, units);
}

/** Formats a mass with two digits, in a suitable unit. */
export function massText(kilograms: number): string {
  return inUnit(kilograms, [[1, 'kg'], [1e3, 'g'], [1e6, 'mg'], [1e9, 'µg']]);
}

// Formats a value in the first unit in which the number is not below one.
function inUnit(value: number, units: readonly [number, string][]): string {
  const last = units.at(-1)!;
  const [factor, unit] = units.find(([scale]) => scale * value >= 0.995) ?? last;
  const digits = factor * value >= 100 ? Math.round(factor * value) : Number((factor * value).toPrecision(2));
  return value > 0 && digits < 0.01 ? `under 0.01 ${last[1]}` : `${digits.toLocaleString('en')} ${unit}`;
}

/**
 * Returns the reply to a cut in a few words, without the server's warnings.
 * @param hasWidth  true if the cut was to remove a strip
 */
export function cutText(result: CutResult, hasWidth = false): string {
  if (result.status === CutResult_Status.NO_INTERSECTION) {
    if (hasWidth) return 'Nothing was cut: there is no material under the strip';
    if (result.closedGaps > 0) return 'Nothing was cut: the line follows an older cut or the border';
    return 'Nothing was cut: the line misses the sheet, or is too small';
  }
  const { removed } = result;
  return `Cut: ${countText(result.pieces, 'piece')}${removed ? `, ${areaText(removed.areaM2)} removed` : ''}`;
}

/** Returns more about the reply to a cut, one sentence each; empty if nothing was cut. */
export function cutDetails(result: CutResult): string[] {
  if (result.status !== CutResult_Status.APPLIED) return [];
  const { removed, layers, tick } = result;
  const whole = removed && removed.pieces > 0 ? `, including ${countText(removed.pieces, 'whole piece')}` : '';
  return [
    `The cut is at most ${lengthText(result.deviationM)} off the line`,
    ...(layers.length > 1 ? [`The line crosses the sheet in ${layers.length} stretches`] : []),
    ...(removed ? [`Removed: ${massText(removed.massKg)}${whole}`] : []),
    `${countText(result.newVertices, 'new vertex', 'new vertices')}, at tick ${tick}`,
  ];
}

/** Returns the server's warnings as sentences; empty if there are none. */
export function warningText({ warnings }: CutResult): string {
  const sentence = (text: string) => `${text.charAt(0).toUpperCase()}${text.slice(1).replace(/[.\s]*$/, '')}.`;
  return warnings.map(sentence).join(' ');
}

/** Formats a number of bytes in a suitable unit. */
export function sizeText(bytes: number): string {
  if (bytes < 1024) return countText(bytes, 'byte');
  const [factor, unit] = bytes < 1024 ** 2 ? [1024, 'KiB'] : [1024 ** 2, 'MiB'];
  return `${Number((bytes / factor).toPrecision(2)).toLocaleString('en')} ${unit}`;
}
