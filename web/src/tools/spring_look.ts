import { Color } from 'three';

const kCalm = new Color(0xffc02e);
const kTaut = new Color(0xe0201b);
// CSS pixels.
const kThinnest = 2;
const kThickest = 8;
// Share of the sheet's diagonal: a longer spring looks no different.
const kLongest = 0.3;

/**
 * Look of the spring of a grab. Its force is in proportion to its length; the stiffness is the server's choice.
 * @param lengthM  from the held vertex to the pointer, metres
 * @param sizeM    the sheet's diagonal, metres, > 0
 */
export function springLook(lengthM: number, sizeM: number): { widthPx: number; color: Color } {
  const part = Math.min(1, lengthM / (kLongest * sizeM));
  return { widthPx: kThinnest + (kThickest - kThinnest) * part, color: kCalm.clone().lerp(kTaut, part) };
}
