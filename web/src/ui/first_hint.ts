const kKey = 'kerf-hint';

type Kept = Pick<Storage, 'getItem' | 'setItem'>;

/** Says in one line what to do first, until it is closed or a tool is tried; on later visits not at all. */
export class FirstHint {
  /**
   * @param storage  asking for it may throw: then each visit is a first one
   */
  constructor(
    private readonly line: HTMLElement,
    close: HTMLElement,
    private readonly storage: () => Kept = () => localStorage,
  ) {
    line.hidden = this.wasSeen();
    close.addEventListener('click', () => this.close());
  }

  close(): void {
    if (this.line.hidden) return;
    this.line.hidden = true;
    try {
      this.storage().setItem(kKey, 'seen');
    } catch {
      // Then it is closed as long as the page is open.
    }
  }

  private wasSeen(): boolean {
    try {
      return this.storage().getItem(kKey) !== null;
    } catch {
      return false;
    }
  }
}
