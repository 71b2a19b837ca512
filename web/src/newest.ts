/**
 * Makes one call at a time, always with the newest value of a sheet, so that a dragged slider does not fill the
 * server's queue.
 */
export class Newest<T> {
  // By sheet: a waiting value goes to the sheet that it was meant for, even if another is shown by then.
  private readonly waiting = new Map<string, T>();
  private isSending = false;

  /**
   * @param send  name: sheets/{sheet}
   * @param done  called when the last value has been answered
   */
  constructor(
    private readonly send: (name: string, value: T) => Promise<unknown>,
    private readonly done: () => Promise<unknown>,
  ) {}

  /** True while the server does not have the newest value yet. */
  get isBusy(): boolean {
    return this.isSending;
  }

  put(name: string, value: T): void {
    this.waiting.set(name, value);
    if (!this.isSending) void this.run();
  }

  private async run(): Promise<void> {
    this.isSending = true;
    // A value put in the meantime is sent last.
    for (const [name, value] of this.waiting) {
      this.waiting.delete(name);
      await this.send(name, value);
    }
    this.isSending = false;
    await this.done();
  }
}
