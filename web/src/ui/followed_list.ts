import { setText } from './dom';
import { errorText } from './error_text';

const kRetryMs = 1000;

/** The sheet that is shown, for a list of what it consists of. */
export interface ListedSheet {
  /** Another object when topology versions begin again. */
  readonly surface: object | undefined;
  /** Undefined before the first frame. */
  readonly topologyVersion: number | undefined;
}

function isSame<Of extends object>(one: Of, other: Of): boolean {
  return (Object.keys(one) as (keyof Of)[]).every((key) => one[key] === other[key]);
}

/**
 * Asks the server for a list while it is open, again whenever what it is of has changed, one request at a time.
 * @typeParam Of  what a list is of; lists of equal members are the same
 */
export class FollowedList<Of extends object> {
  private isOpen = false;
  private isAsking = false;
  private listed: Of | undefined;

  /**
   * @param error  shows why the list is not up to date
   * @param now    returns what the list should be of now; undefined: nothing can be listed
   * @param fetch  shows the list, and returns what it is of; undefined if it has to be asked for again
   */
  constructor(
    private readonly error: HTMLElement,
    private readonly now: () => Of | undefined,
    private readonly fetch: (of: Of) => Promise<Of | undefined>,
  ) {}

  open(): void {
    this.isOpen = true;
    this.update();
  }

  close(): void {
    this.isOpen = false;
  }

  /** Updates the list. It may be called with each frame, and is cheap if nothing has changed. */
  update(): void {
    if (!this.isOpen || this.isAsking) return;
    const of = this.now();
    if (!of || (this.listed && isSame(of, this.listed))) return;
    this.isAsking = true;
    this.fetch(of).then(
      (listed) => {
        this.listed = listed;
        this.isAsking = false;
        this.error.hidden = true;
        // Asks again here, because a still sheet has no frame that would do so.
        if (listed === undefined) this.update();
      },
      (error: Error) => this.failed(error),
    );
  }

  private failed(error: Error): void {
    this.listed = undefined;
    setText(this.error, `The list is not up to date: ${errorText(error)}`);
    this.error.hidden = false;
    // Asks again after a while: not with each frame, but also for a still sheet, which has no frames.
    setTimeout(() => {
      this.isAsking = false;
      this.update();
    }, kRetryMs);
  }
}

/** Calls `point` with true while a row's button is pointed at or has the keyboard, and then with false. */
export function whenPointedAt(button: HTMLElement, point: (isPointedAt: boolean) => void): void {
  for (const event of ['pointerenter', 'focus']) button.addEventListener(event, () => point(true));
  for (const event of ['pointerleave', 'blur']) button.addEventListener(event, () => point(false));
}
