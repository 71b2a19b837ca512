/** One call at a time, always with the newest value: a dragged slider does not fill the server's queue. */
export class Newest<T> {
  private waiting: { value: T } | undefined;
  private isSending = false;

  /** @param done  called when the last value has been answered */
  constructor(
    private readonly send: (value: T) => Promise<unknown>,
    private readonly done: () => Promise<unknown>,
  ) {}

  /** What the server has is not what was asked for last. */
  get isBusy(): boolean {
    return this.isSending;
  }

  put(value: T): void {
    this.waiting = { value };
    if (!this.isSending) void this.run();
  }

  private async run(): Promise<void> {
    this.isSending = true;
    while (this.waiting) {
      const { value } = this.waiting;
      this.waiting = undefined;
      await this.send(value);
    }
    this.isSending = false;
    await this.done();
  }
}
