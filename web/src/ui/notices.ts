import type { NoticeKind } from '../tools/tool';

const kMaxShown = 4;
const kShownMs: Record<NoticeKind, number> = { info: 4000, success: 6000, warning: 12000, error: 9000 };

/** Short messages that go away by themselves, or when clicked. */
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
    while (this.container.children.length > kMaxShown) this.container.firstElementChild?.remove();
    setTimeout(() => notice.remove(), kShownMs[kind]);
  }
}
