import type { SheetArrays } from './sheet_copy';

/**
 * Returns 8 hex digits (FNV-1a, 32 bits): equal for triangles, pieces and material positions that are equal bit for
 * bit. World positions do not count.
 */
export function meshHash(sheet: SheetArrays): string {
  let hash = 0x811c9dc5;
  const add = (array: Int32Array | Float32Array) => {
    for (const byte of new Uint8Array(array.buffer, array.byteOffset, array.byteLength)) {
      hash = Math.imul(hash ^ byte, 0x01000193);
    }
  };
  add(Int32Array.of(sheet.numVertices, sheet.numSlots));
  add(sheet.triangles.subarray(0, 3 * sheet.numSlots));
  add(sheet.pieces.subarray(0, sheet.numSlots));
  add(sheet.materialPositions.subarray(0, 2 * sheet.numVertices));
  return (hash >>> 0).toString(16).padStart(8, '0');
}
