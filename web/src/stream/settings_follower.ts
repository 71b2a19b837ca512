// Least time between two fetches, and the longer wait after a fetch that failed.
const kIntervalMs = 250;
const kRetryMs = 1000;

/**
 * Fetches a sheet's settings whenever a frame has another settings version than the last fetch. A change too soon after
 * that fetch waits for a timer, not for another frame, because a paused sheet sends none.
 */
export class SettingsFollower {
  private wanted: number | undefined;
  private held: number | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private nextMs = 0;
  // The fetch in progress; answers to earlier ones are ignored.
  private running: object | undefined;

  /** @param fetch  fetches the settings; false or a rejection: it failed and is tried again */
  constructor(private readonly fetch: () => Promise<boolean>) {}

  /** Call it for each frame, with its settings version. */
  saw(version: number): void {
    this.wanted = version;
    this.schedule();
  }

  /** Forgets all versions, and fetches nothing before the next saw(). */
  reset(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    this.running = undefined;
    this.wanted = undefined;
    this.held = undefined;
  }

  private schedule(): void {
    if (this.wanted === this.held || this.running || this.timer !== undefined) return;
    const waitMs = this.nextMs - performance.now();
    if (waitMs <= 0) void this.run();
    else this.timer = setTimeout(() => void this.run(), waitMs);
  }

  private async run(): Promise<void> {
    this.timer = undefined;
    const version = this.wanted;
    const mine = {};
    this.running = mine;
    this.nextMs = performance.now() + kIntervalMs;
    const isFetched = await this.fetch().catch(() => false);
    if (this.running !== mine) return;
    this.running = undefined;
    if (isFetched) this.held = version;
    else this.nextMs = performance.now() + kRetryMs;
    this.schedule();
  }
}
