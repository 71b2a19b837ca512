import { Color } from 'three';
import type { SheetArrays } from '../stream/sheet_copy';

// Okabe and Ito, "Color universal design" (2008), without black: distinguishable for the colour-blind too. Neighbours
// in the list, such as the two parts of a cut, differ most.
const kPalette = [0x0072b2, 0xe69f00, 0x009e73, 0xcc79a7, 0x56b4e9, 0xd55e00, 0xf0e442];
// Later rounds through the palette are mixed with white, then with black.
const kRounds: readonly [number, number][] = [
  [0xffffff, 0],
  [0xffffff, 0.5],
  [0x000000, 0.4],
];
const kUnknown = new Color(0x9a9a9a);

/**
 * Returns the colour of a piece, which depends only on its id (1, 2, ...). A piece thus keeps its colour until it is
 * cut itself.
 */
export function pieceColor(id: number): Color {
  const round = Math.floor((id - 1) / kPalette.length) % kRounds.length;
  const [towards, share] = kRounds[round];
  return new Color(kPalette[(id - 1) % kPalette.length]).lerp(new Color(towards), share);
}

/**
 * Returns a colour for each vertex, 3 V numbers, linear. This is possible because no two pieces share a vertex.
 *
 * @param ids     label -> id
 */
export function pieceColors(mirror: SheetArrays, ids: ReadonlyMap<number, number>): Float32Array {
  const colors = new Map([...ids].map(([label, id]) => [label, pieceColor(id)]));
  const out = new Float32Array(3 * mirror.numVertices);
  for (let slot = 0; slot < mirror.numSlots; ++slot) {
    if (mirror.triangles[3 * slot] < 0) continue;
    const color = colors.get(mirror.pieces[slot]) ?? kUnknown;
    for (let corner = 0; corner < 3; ++corner) color.toArray(out, 3 * mirror.triangles[3 * slot + corner]);
  }
  return out;
}

/**
 * Returns colours to show until the ids of a new topology arrive. Old vertices keep their colours; new ones, and those
 * that have material again, get the colour of a neighbour.
 *
 * @param old  colours in the topology before, 3 numbers per vertex
 */
export function carriedColors(mirror: SheetArrays, old: Float32Array): Float32Array {
  const out = new Float32Array(3 * mirror.numVertices);
  out.set(old.subarray(0, out.length));
  const { triangles } = mirror;
  // A vertex without material is black, which means no colour; it gets material again if its cut is undone.
  const isKnown = (first: number) => first < old.length && old[first] + old[first + 1] + old[first + 2] > 0;
  for (let slot = 0; slot < mirror.numSlots; ++slot) {
    const corners = [0, 1, 2].map((corner) => 3 * triangles[3 * slot + corner]);
    if (corners[0] < 0) continue;
    const known = corners.find(isKnown) ?? -1;
    for (const first of corners) {
      if (isKnown(first)) continue;
      if (known >= 0) out.set(old.subarray(known, known + 3), first);
      else if (out[first] + out[first + 1] + out[first + 2] === 0) kUnknown.toArray(out, first);
    }
  }
  return out;
}
