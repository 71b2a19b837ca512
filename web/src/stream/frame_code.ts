// Reads the arrays of compact frames: server/service/codec/position_code.h and topology_code.h. All throw CodeError.
import { CodeError, unpackIntegers, unzigzag } from './packed_integers';
import { kNoVertex } from './predictors';
import type { Predictors } from './predictors';

/**
 * @param base       `baseCount` coordinates of the base frame; a keyframe has none
 * @param positions  receives 3 coordinates per vertex; must not be `base`
 * @param room       scratch space for 3 numbers per vertex; allocated if absent or too small
 */
export function unpackPositions(
  bytes: Uint8Array,
  base: Uint16Array,
  baseCount: number,
  { nearA, nearB, across }: Predictors,
  positions: Uint16Array,
  room?: Uint32Array,
): void {
  const count = 3 * nearA.length;
  const differences = unpackIntegers(bytes, count, 3, room);
  for (let at = 0, vertex = 0; at < count; at += 3, ++vertex) {
    const a = 3 * nearA[vertex];
    const b = 3 * nearB[vertex];
    const c = 3 * across[vertex];
    for (let axis = 0; axis < 3; ++axis) {
      let foretold = 0;
      if (at < baseCount) {
        foretold = base[at + axis];
        if (a >= 0) {
          const wayA = ((positions[a + axis] - base[a + axis]) << 16) >> 16;
          if (b < 0) foretold += wayA;
          else foretold += (wayA + (((positions[b + axis] - base[b + axis]) << 16) >> 16)) >> 1;
        }
      } else if (a >= 0) {
        foretold = positions[a + axis];
        if (c >= 0) foretold += positions[b + axis] - positions[c + axis];
      }
      // A Uint16Array keeps the low 16 bits.
      positions[at + axis] = foretold + unzigzag(differences[at + axis]);
    }
  }
}

/** Returns one signed number -128..127 per vertex. `room` is as in unpackPositions(). */
export function unpackBytes(bytes: Uint8Array, { nearA, nearB }: Predictors, room?: Uint32Array): Int8Array {
  const differences = unpackIntegers(bytes, nearA.length, 1, room);
  const values = new Int8Array(nearA.length);
  for (let vertex = 0; vertex < values.length; ++vertex) {
    let foretold = nearA[vertex] === kNoVertex ? 0 : values[nearA[vertex]];
    if (nearB[vertex] !== kNoVertex) foretold = (foretold + values[nearB[vertex]]) >> 1;
    // An Int8Array keeps the low 8 bits.
    values[vertex] = foretold + unzigzag(differences[vertex]);
  }
  return values;
}

export function unpackAscending(bytes: Uint8Array, count: number): Uint32Array {
  const ids = unpackIntegers(bytes, count, 1);
  let next = 0;
  for (let i = 0; i < count; ++i) {
    next += ids[i];
    if (next > 0xffffffff) throw new CodeError(`id ${next}`);
    ids[i] = next++;
  }
  return ids;
}

/** @param whole  true for all slots of a full patch, false for the slots that a patch lists */
export function unpackTriangles(bytes: Uint8Array, count: number, whole: boolean): Int32Array {
  const differences = unpackIntegers(bytes, 3 * count, 3);
  const triangles = new Int32Array(3 * count);
  for (let at = 0; at < triangles.length; ++at) {
    let foretold = at >= 3 ? triangles[at - 3] : 0;
    if (whole && at >= 6) foretold += triangles[at - 6] - (at >= 9 ? triangles[at - 9] : 0);
    triangles[at] = foretold + unzigzag(differences[at]);
  }
  return triangles;
}

export function unpackLabels(bytes: Uint8Array, count: number): Int32Array {
  const differences = unpackIntegers(bytes, count, 1);
  const labels = new Int32Array(count);
  let last = 0;
  for (let i = 0; i < count; ++i) labels[i] = last = (last + unzigzag(differences[i])) | 0;
  return labels;
}

// Maps a 32-bit float to an integer; greater floats have greater integers.
const floatBits = new DataView(new ArrayBuffer(4));
function orderOf(value: number): number {
  floatBits.setFloat32(0, value);
  const bits = floatBits.getUint32(0);
  return bits & 0x80000000 ? ~bits : bits | 0x80000000;
}
function floatOf(order: number): number {
  floatBits.setUint32(0, order & 0x80000000 ? order & 0x7fffffff : ~order);
  return floatBits.getFloat32(0);
}

/**
 * @param listed    ids of the vertices whose positions `bytes` has, ascending
 * @param material  2 numbers per vertex; has the other vertices' positions, receives those of the listed ones
 */
export function unpackMaterialPositions(
  bytes: Uint8Array,
  listed: Uint32Array,
  { nearA, nearB, across }: Predictors,
  material: Float32Array,
): void {
  const differences = unpackIntegers(bytes, 2 * listed.length, 2);
  for (let i = 0; i < listed.length; ++i) {
    const vertex = listed[i];
    for (let axis = 0; axis < 2; ++axis) {
      let foretold = 0;
      if (nearA[vertex] !== kNoVertex) {
        foretold = material[2 * nearA[vertex] + axis];
        if (across[vertex] !== kNoVertex) {
          foretold = Math.fround(foretold + material[2 * nearB[vertex] + axis] - material[2 * across[vertex] + axis]);
        }
      }
      material[2 * vertex + axis] = floatOf(orderOf(foretold) + unzigzag(differences[2 * i + axis]));
    }
  }
}
