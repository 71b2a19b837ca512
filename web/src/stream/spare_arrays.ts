// More than there are frames on their way between worker and page, each with positions and strains.
const kMaxKept = 16;

/** Buffers that come back from where they were sent, to be filled again instead of allocating others for each frame. */
export class SpareArrays {
  private buffers: ArrayBuffer[] = [];

  /** Number of buffers that had to be allocated. */
  numAllocated = 0;

  put(buffers: readonly ArrayBuffer[]): void {
    this.buffers.push(...buffers);
    // The largest of a mesh that grows came last.
    if (this.buffers.length > kMaxKept) this.buffers = this.buffers.slice(-kMaxKept);
  }

  /** The first `count` numbers of `array`, in a buffer of its own. */
  copyOf(array: Float32Array, count: number): Float32Array {
    const numBytes = 4 * count;
    const found = this.buffers.findIndex((buffer) => buffer.byteLength >= numBytes && buffer.byteLength <= 4 * numBytes);
    const buffer = found < 0 ? new ArrayBuffer(numBytes) : this.buffers.splice(found, 1)[0];
    if (found < 0) this.numAllocated += 1;
    const copy = new Float32Array(buffer, 0, count);
    copy.set(array.subarray(0, count));
    return copy;
  }
}
