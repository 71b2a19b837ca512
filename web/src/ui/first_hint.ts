const kKey = 'kerf-hint';

type Kept = Pick<Storage, 'getItem' | 'setItem'>;

/** Says in one line what to do first, until it is closed or a tool is tried. Later visits do not show it. */
export class FirstHint {
  /**
   * @param storage  may throw; each visit then counts as the first
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
      // Without storage the hint stays closed only while the page is open.
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
