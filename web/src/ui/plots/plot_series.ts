/** Values of one probe over time. A new sample drops the oldest one beyond `most`. */
export class PlotSeries {
  /** Names of the values of a sample, such as "x"; empty before the first sample. */
  names: readonly string[] = [];
  readonly ticks: number[] = [];
  readonly samples: (readonly number[])[] = [];

  constructor(private readonly most: number) {}

  /** Adds a sample; one of an earlier tick, or with other names, begins again. */
  add(tick: number, names: readonly string[], values: readonly number[]): void {
    const last = this.ticks.at(-1);
    if (tick === last) return;
    if ((last !== undefined && tick < last) || names.join() !== this.names.join()) this.clear();
    this.names = names;
    this.ticks.push(tick);
    this.samples.push(values);
    if (this.ticks.length > this.most) {
      // Drops a part at a time, because an array shifts all that it keeps.
      const drop = Math.ceil(this.most / 10);
      this.ticks.splice(0, drop);
      this.samples.splice(0, drop);
    }
  }

  clear(): void {
    this.ticks.length = 0;
    this.samples.length = 0;
  }

  /** Smallest and largest finite value; undefined if there is none. */
  get range(): [low: number, high: number] | undefined {
    let [low, high] = [Infinity, -Infinity];
    for (const sample of this.samples) {
      for (const value of sample) {
        if (!Number.isFinite(value)) continue;
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
    return low <= high ? [low, high] : undefined;
  }

  /** Index of the sample nearest to a tick; -1 without samples. */
  nearest(tick: number): number {
    let [nearest, least] = [-1, Infinity];
    this.ticks.forEach((at, i) => {
      if (Math.abs(at - tick) < least) [nearest, least] = [i, Math.abs(at - tick)];
    });
    return nearest;
  }

  /**
   * Returns the samples as comma-separated values; a missing value is empty.
   * @param tickS  simulated seconds of a tick
   * @param scale  factor on values
   * @param unit   of the values after scaling, for the heading
   */
  csv(title: string, tickS: number, scale: number, unit: string): string {
    const heading = ['tick', 'time_s', ...this.names.map((name) => `${title}.${name}_${unit}`)];
    const rows = this.samples.map((sample, i) => {
      const values = sample.map((value) => (Number.isFinite(value) ? String(scale * value) : ''));
      return [this.ticks[i], Number((this.ticks[i] * tickS).toPrecision(12)), ...values].join(',');
    });
    return `${[heading.map((text) => text.replaceAll(/[\s,]/g, '_')).join(','), ...rows].join('\n')}\n`;
  }
}

/** Returns round numbers in a range, ascending, about `count` of them: multiples of 1, 2 or 5 times a power of ten. */
export function niceTicks(low: number, high: number, count: number): number[] {
  const span = high - low;
  if (!(span > 0)) return [low];
  const rough = span / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((each) => each >= 0.7 * rough)!;
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}
