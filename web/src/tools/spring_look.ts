import { Color } from 'three';

const kCalm = new Color(0xffc02e);
const kTaut = new Color(0xe0201b);
// CSS pixels.
const kThinnest = 2;
const kThickest = 8;
// Length, as a share of the sheet's diagonal, beyond which the look of the spring stays the same.
const kLongest = 0.3;

/**
 * Returns the look of a grab's spring. The force is proportional to the length; the server chooses the stiffness.
 * @param lengthM  distance from the held vertex to the pointer, metres
 * @param sizeM    the sheet's diagonal, metres, > 0
 */
export function springLook(lengthM: number, sizeM: number): { widthPx: number; color: Color } {
  const part = Math.min(1, lengthM / (kLongest * sizeM));
  return { widthPx: kThinnest + (kThickest - kThinnest) * part, color: kCalm.clone().lerp(kTaut, part) };
}
