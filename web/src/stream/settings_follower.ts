// Fetches changes at most this often, however often it changes; a fetch that failed is repeated after the
// longer wait.
const kIntervalMs = 250;
const kRetryMs = 1000;

/**
 * Fetches a sheet's settings whenever a frame tells of others than those last fetched. A change that comes too soon
 * after the last fetch is fetched when its time has come, whether or not another frame arrives: a paused sheet sends
 * none.
 */
export class SettingsFollower {
  private wanted: number | undefined;
  private held: number | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private nextMs = 0;
  // The fetch under way; an answer to an earlier one means nothing.
  private running: object | undefined;

  /** @param fetch  false or a rejection: it failed, try again */
  constructor(private readonly fetch: () => Promise<boolean>) {}

  /** A frame came with this settings version. */
  saw(version: number): void {
    this.wanted = version;
    this.schedule();
  }

  /** Forgets what was seen and fetched, and fetches nothing before the next saw(). */
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
