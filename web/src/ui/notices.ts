import type { NoticeKind, Reporter } from '../notifier';
import { icon, make } from './dom';
import { errorText } from './error_text';

const kMaxShown = 4;
const kShownMs: Record<NoticeKind, number> = { info: 4000, success: 6000, warning: 12000, error: 9000 };

/** Shows short messages, which disappear after a while or when clicked, unless their details are open. Offers stay. */
export class Notices implements Reporter {
  constructor(private readonly container: HTMLElement) {}

  notify(kind: NoticeKind, text: string, details: readonly string[] = []): void {
    // Replaces a notice with the same text, which is thus shown once, and longer.
    this.container.querySelector(`.notice[data-text="${CSS.escape(text)}"]`)?.remove();
    const notice = make('div', { className: 'card notice' }, text);
    notice.dataset.kind = kind;
    notice.dataset.text = text;
    if (kind === 'error') notice.setAttribute('role', 'alert');
    const more = details.length > 0 ? detailsOf(details) : undefined;
    if (more) notice.append(more);
    notice.addEventListener('click', ({ target }) => {
      if (!more?.contains(target as Node)) notice.remove();
    });
    this.container.append(notice);
    const brief = this.container.querySelectorAll('.notice:not(.offer)');
    for (let i = 0; i + kMaxShown < brief.length; ++i) brief[i].remove();
    let timer = setTimeout(() => notice.remove(), kShownMs[kind]);
    more?.addEventListener('toggle', () => {
      clearTimeout(timer);
      if (!more.open) timer = setTimeout(() => notice.remove(), kShownMs[kind]);
    });
  }

  async attempt<T>(run: () => Promise<T>, what = ''): Promise<T | undefined> {
    try {
      return await run();
    } catch (error) {
      this.notify('error', `${what}${errorText(error as Error)}`);
      return undefined;
    }
  }

  /**
   * Shows a line with a button, until it is closed or the button is pressed.
   * @returns a function that closes the line
   */
  offer(text: string, label: string, accept: () => void): () => void {
    const accepting = make('button', { type: 'button', className: 'primary' }, label);
    const closing = make('button', { type: 'button', className: 'icon', title: 'Close', 'aria-label': 'Close' }, icon('close'));
    const notice = make('div', { className: 'card notice offer' }, make('span', {}, text), accepting, closing);
    accepting.addEventListener('click', () => {
      notice.remove();
      accept();
    });
    closing.addEventListener('click', () => notice.remove());
    this.container.append(notice);
    return () => notice.remove();
  }
}

function detailsOf(lines: readonly string[]): HTMLDetailsElement {
  return make('details', {}, make('summary', {}, 'Details'), ...lines.map((line) => make('p', {}, `${line}.`)));
}
