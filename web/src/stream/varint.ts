/**
 * Adds zigzag base-128 varint differences to quantised coordinates (kerf.v1.Frame.positions of a delta).
 *
 * @param bytes     exactly `count` varints
 * @param base      coordinates of the base frame, at least `baseCount`; beyond that the base is 0
 * @param out       receives `count` coordinates in 0..65535; may be `base` itself
 * @throws RangeError if the bytes end early or late, a varint is longer than 3 bytes, or a coordinate leaves 0..65535
 */
export function addZigzagDeltas(
  bytes: Uint8Array,
  base: Uint16Array,
  baseCount: number,
  out: Uint16Array,
  count: number,
): void {
  let at = 0;
  for (let i = 0; i < count; ++i) {
    let value = bytes[at++];
    if (!(value < 0x80)) {
      // A difference of 16-bit numbers, zigzagged, has 17 bits: at most 3 bytes.
      const second = bytes[at++];
      value = (value & 0x7f) | ((second & 0x7f) << 7);
      if (second >= 0x80) {
        const third = bytes[at++];
        if (third >= 0x80) throw new RangeError(`difference ${i} is longer than 3 bytes`);
        value |= third << 14;
      }
      if (at > bytes.length) throw new RangeError(`bytes end within difference ${i} of ${count}`);
    }
    const q = (i < baseCount ? base[i] : 0) + ((value >>> 1) ^ -(value & 1));
    if (q < 0 || q > 0xffff) throw new RangeError(`coordinate ${i} leaves 0..65535: ${q}`);
    out[i] = q;
  }
  if (at !== bytes.length) throw new RangeError(`${bytes.length - at} bytes left over after ${count} differences`);
}
