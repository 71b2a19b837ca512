/**
 * Keeps the numbers added in the last `spanMs`, with their times. At most `capacity` are kept; a newer one replaces the
 * oldest. It allocates nothing after construction.
 */
export class SampleWindow {
  private readonly times: Float64Array;
  private readonly values: Float64Array;
  private readonly sorted: Float64Array;
  private first = 0;
  private length = 0;

  constructor(
    readonly spanMs: number,
    capacity: number,
  ) {
    this.times = new Float64Array(capacity);
    this.values = new Float64Array(capacity);
    this.sorted = new Float64Array(capacity);
  }

  /** Number of samples. */
  get count(): number {
    return this.length;
  }

  /** @param atMs  time of the number, not before the time of the previous one */
  add(atMs: number, value: number): void {
    const { length: capacity } = this.times;
    const end = (this.first + this.length) % capacity;
    this.times[end] = atMs;
    this.values[end] = value;
    if (this.length < capacity) this.length += 1;
    else this.first = (this.first + 1) % capacity;
    this.forget(atMs);
  }

  /** Drops numbers that are older than the span at `nowMs`. */
  forget(nowMs: number): void {
    while (this.length > 0 && nowMs - this.times[this.first] >= this.spanMs) {
      this.first = (this.first + 1) % this.times.length;
      this.length -= 1;
    }
  }

  clear(): void {
    this.length = 0;
  }

  /** Visits the numbers from the oldest to the newest. */
  forEach(use: (atMs: number, value: number) => void): void {
    for (let i = 0; i < this.length; ++i) {
      const at = (this.first + i) % this.times.length;
      use(this.times[at], this.values[at]);
    }
  }

  sum(): number {
    let sum = 0;
    this.forEach((_, value) => (sum += value));
    return sum;
  }

  max(): number {
    let max = Number.NEGATIVE_INFINITY;
    this.forEach((_, value) => (max = Math.max(max, value)));
    return max;
  }

  /** Returns the newest number; undefined if there is none. */
  last(): number | undefined {
    return this.length === 0 ? undefined : this.values[(this.first + this.length - 1) % this.values.length];
  }

  /**
   * Returns `sum` (by default the count) per second, over the time since the oldest number was added, at least a
   * quarter of the span.
   */
  rate(nowMs: number, sum = this.length): number {
    if (this.length === 0) return 0;
    return (1000 * sum) / Math.max(0.25 * this.spanMs, nowMs - this.times[this.first]);
  }

  /**
   * Returns the smallest number that at least the share `q` of the numbers do not exceed (nearest rank); undefined if
   * there is none.
   * @param q  0..1
   */
  quantile(q: number): number | undefined {
    if (this.length === 0) return undefined;
    let at = 0;
    this.forEach((_, value) => (this.sorted[at++] = value));
    const sorted = this.sorted.subarray(0, this.length).sort();
    return sorted[Math.max(0, Math.ceil(q * this.length) - 1)];
  }
}
