import type { NoticeKind } from '../tools/tool';
import { icon, make } from './dom';

const kMaxShown = 4;
const kShownMs: Record<NoticeKind, number> = { info: 4000, success: 6000, warning: 12000, error: 9000 };

/** Short messages that go away by themselves, or when clicked, and offers that stay. */
export class Notices {
  constructor(private readonly container: HTMLElement) {}

  add(kind: NoticeKind, text: string): void {
    const notice = document.createElement('div');
    notice.className = 'card notice';
    notice.dataset.kind = kind;
    notice.textContent = text;
    if (kind === 'error') notice.setAttribute('role', 'alert');
    notice.addEventListener('click', () => notice.remove());
    this.container.append(notice);
    const brief = this.container.querySelectorAll('.notice:not(.offer)');
    for (let i = 0; i + kMaxShown < brief.length; ++i) brief[i].remove();
    setTimeout(() => notice.remove(), kShownMs[kind]);
  }

  /**
   * Shows a line with a button until it is closed, or the button is pressed.
   * @returns what closes it
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
