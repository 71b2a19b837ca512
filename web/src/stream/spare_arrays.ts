// Largest number of buffers kept: more than the positions and strains of all frames in transit between worker and page.
const kMaxKept = 16;

/** Keeps buffers that the page has returned, to be filled again, so that frames need no new ones. */
export class SpareArrays {
  private buffers: ArrayBuffer[] = [];

  /** Number of buffers that had to be allocated. */
  numAllocated = 0;

  put(buffers: readonly ArrayBuffer[]): void {
    this.buffers.push(...buffers);
    // Keeps the last ones, which are the largest if the mesh grows.
    if (this.buffers.length > kMaxKept) this.buffers = this.buffers.slice(-kMaxKept);
  }

  /** Returns a copy of the first `count` numbers of `array`, in a buffer of its own. */
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
