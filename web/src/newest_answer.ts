/**
 * Takes a server's answers in the order of the questions. Drops an answer that arrives after the answer to a later
 * question, or whose question was sent before a change was answered.
 */
export class NewestAnswer<T> {
  private numAsked = 0;
  // Answers to this question and to earlier ones are old.
  private oldUpTo = 0;
  private last: { number: number; isTaken: Promise<boolean> } | undefined;

  constructor(
    private readonly get: () => Promise<T>,
    private readonly take: (answer: T) => void,
  ) {}

  /** Asks the server. False if that failed; true once this answer, or one at least as new, has been taken. */
  fetch(): Promise<boolean> {
    const number = ++this.numAsked;
    const isTaken = this.ask(number);
    this.last = { number, isTaken };
    return isTaken;
  }

  /** Asks after a change was answered, because answers to earlier questions may lack the change. */
  refresh(): Promise<boolean> {
    this.oldUpTo = this.numAsked;
    return this.fetch();
  }

  /**
   * Makes a change whose answer is of the same kind as the answers to questions.
   * @param change  resolves to undefined if the change failed
   */
  async command(change: () => Promise<T | undefined>): Promise<void> {
    const number = ++this.numAsked;
    const answer = await change();
    if (answer === undefined) return;
    const isOld = number <= this.oldUpTo;
    const isAskedMeanwhile = this.numAsked > number;
    this.oldUpTo = this.numAsked;
    if (!isOld) this.take(answer);
    // Asks again, because the answer to a question asked in the meantime may be older or newer than this one.
    if (isOld || isAskedMeanwhile) await this.fetch();
  }

  private async ask(number: number): Promise<boolean> {
    const answer = await this.get().catch(() => undefined);
    if (answer === undefined) return false;
    if (number <= this.oldUpTo) return this.last!.number > number ? this.last!.isTaken : true;
    this.oldUpTo = number;
    this.take(answer);
    return true;
  }
}
