import type { NoticeKind } from '../tools/tool';
import { make } from './dom';

const kMaxShown = 4;
const kShownMs: Record<NoticeKind, number> = { info: 4000, success: 6000, warning: 12000, error: 9000 };

/** Short messages that go away by themselves, or when clicked. One whose details are open stays. */
export class Notices {
  constructor(private readonly container: HTMLElement) {}

  /** @param details  lines that open on request; without any there is nothing to open */
  add(kind: NoticeKind, text: string, details: readonly string[] = []): void {
    const notice = make('div', { className: 'card notice' }, text);
    notice.dataset.kind = kind;
    if (kind === 'error') notice.setAttribute('role', 'alert');
    const more = details.length > 0 ? detailsOf(details) : undefined;
    if (more) notice.append(more);
    notice.addEventListener('click', ({ target }) => {
      if (!more?.contains(target as Node)) notice.remove();
    });
    this.container.append(notice);
    while (this.container.children.length > kMaxShown) this.container.firstElementChild?.remove();
    let timer = setTimeout(() => notice.remove(), kShownMs[kind]);
    more?.addEventListener('toggle', () => {
      clearTimeout(timer);
      if (!more.open) timer = setTimeout(() => notice.remove(), kShownMs[kind]);
    });
  }
}

function detailsOf(lines: readonly string[]): HTMLDetailsElement {
  return make('details', {}, make('summary', {}, 'Details'), ...lines.map((line) => make('p', {}, `${line}.`)));
}
