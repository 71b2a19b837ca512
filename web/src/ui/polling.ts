/** Asks again and again, one question at a time, while it is on and the page is seen. */
export class Polling {
  private isOn = false;
  private isAsking = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** @param periodMs  from one answer to the next question */
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

  /** Asks at once; what is being asked already is waited for. */
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
