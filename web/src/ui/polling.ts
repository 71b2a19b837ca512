/** Asks repeatedly, one question at a time, while it is on and the page is visible. */
export class Polling {
  private isOn = false;
  private isAsking = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** @param periodMs  time from an answer to the next question */
  constructor(
    private readonly ask: () => Promise<unknown>,
    private readonly periodMs: number,
  ) {
    document.addEventListener('visibilitychange', () => this.now());
  }

  start(): void {
    this.isOn = true;
    this.now();
  }

  stop(): void {
    this.isOn = false;
    clearTimeout(this.timer);
  }

  /** Asks at once, unless a question is already waiting for its answer. */
  now(): void {
    clearTimeout(this.timer);
    if (!this.isOn || this.isAsking || document.hidden) return;
    this.isAsking = true;
    void this.ask().finally(() => {
      this.isAsking = false;
      if (this.isOn) this.timer = setTimeout(() => this.now(), this.periodMs);
    });
  }
}
