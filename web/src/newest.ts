/** One call at a time, always with a sheet's newest value: a dragged slider does not fill the server's queue. */
export class Newest<T> {
  // By sheet: what waits goes to the sheet that it was meant for, whichever is shown by then.
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

  /** The server does not have the newest request yet. */
  get isBusy(): boolean {
    return this.isSending;
  }

  put(name: string, value: T): void {
    this.waiting.set(name, value);
    if (!this.isSending) void this.run();
  }

  private async run(): Promise<void> {
    this.isSending = true;
    // A value that is put meanwhile comes last.
    for (const [name, value] of this.waiting) {
      this.waiting.delete(name);
      await this.send(name, value);
    }
    this.isSending = false;
    await this.done();
  }
}
