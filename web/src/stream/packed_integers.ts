// Reads server/service/codec/packed_integers.h: blocks of Rice codes.

const kBlockRows = 16;
const kParameterBits = 5;
const kAllZero = 31;
const kEscape = 16;

/** Thrown for bytes that the sender's encoder cannot have made. */
export class CodeError extends Error {
  override readonly name = 'CodeError';
}

export function unzigzag(value: number): number {
  return (value >>> 1) ^ -(value & 1);
}

class BitReader {
  private at = 0;
  private pending = 0;
  // Number of bits in `pending`, at most 32; below 0 once more bits were taken than there are.
  private numPending = 0;

  constructor(private readonly bytes: Uint8Array) {}

  /** @param count  0..25 */
  take(count: number): number {
    this.refill();
    const value = this.pending & ((1 << count) - 1);
    this.drop(count);
    return value;
  }

  /** @param count  0..32 */
  takeLong(count: number): number {
    if (count <= 16) return this.take(count);
    const low = this.take(16);
    return (low | (this.take(count - 16) << 16)) >>> 0;
  }

  /** Takes the ones before the next zero, and the zero; at most kEscape ones. Returns their number. */
  takeUnary(): number {
    this.refill();
    const ones = Math.min(31 - Math.clz32(~this.pending & (this.pending + 1)), kEscape);
    this.drop(ones === kEscape ? kEscape : ones + 1);
    return ones;
  }

  get overrun(): boolean {
    return this.numPending < 0;
  }

  /** True if nothing is left except the zeros that fill the last byte. */
  get atEnd(): boolean {
    return this.numPending >= 0 && this.numPending < 8 && this.at === this.bytes.length && this.pending === 0;
  }

  private refill(): void {
    while (this.numPending >= 0 && this.numPending <= 16 && this.at < this.bytes.length) {
      this.pending |= this.bytes[this.at++] << this.numPending;
      this.numPending += 8;
    }
  }

  private drop(count: number): void {
    this.pending >>>= count;
    this.numPending -= count;
  }
}

/**
 * @param count    number of numbers, a multiple of `columns`
 * @param columns  numbers in each row
 * @param room     array for the result, used if it is long enough; its content is overwritten
 * @throws CodeError if the bytes are not exactly those of `count` numbers
 */
export function unpackIntegers(bytes: Uint8Array, count: number, columns: number, room?: Uint32Array): Uint32Array {
  const rows = count / columns;
  if (!Number.isInteger(rows) || rows < 0) throw new CodeError(`${count} numbers in rows of ${columns}`);
  // Each column of a block has a parameter, so the bytes bound the count before anything is allocated.
  if ((8 * bytes.length) / kParameterBits < Math.ceil(rows / kBlockRows) * columns) {
    throw new CodeError(`${bytes.length} bytes for ${count} numbers`);
  }
  const values = room && room.length >= count ? room.subarray(0, count).fill(0) : new Uint32Array(count);
  const reader = new BitReader(bytes);
  for (let row = 0; row < rows; row += kBlockRows) {
    const end = Math.min(row + kBlockRows, rows) * columns;
    for (let column = 0; column < columns; ++column) {
      const parameter = reader.take(kParameterBits);
      if (parameter === kAllZero) continue;
      for (let at = row * columns + column; at < end; at += columns) {
        const quotient = reader.takeUnary();
        values[at] = quotient === kEscape ? reader.takeLong(32) : (quotient << parameter) | reader.takeLong(parameter);
      }
      if (reader.overrun) throw new CodeError(`bytes end within ${count} numbers`);
    }
  }
  if (!reader.atEnd) throw new CodeError(`bytes are left over after ${count} numbers`);
  return values;
}
