import type { TransferOptions } from '../api';
import type { NoticeKind } from '../tools/tool';
import { element, setText } from './dom';
import { errorText } from './error_text';

// A shorter one is over before it could be read about.
const kShownAfterMs = 200;

/** A file on its way to or from the server: one at a time, shown in the header while it takes long, cancelled there. */
export class Transfer {
  private readonly chip = element('transfer');
  private readonly progress = element<HTMLProgressElement>('transfer-progress');
  private running: AbortController | undefined;

  constructor(private readonly notices: { notify(kind: NoticeKind, text: string): void }) {
    element('transfer-cancel').addEventListener('click', () => this.running?.abort());
  }

  get isOn(): boolean {
    return this.running !== undefined;
  }

  /**
   * What `work` gives; undefined where it failed or was cancelled, which a notice tells.
   * @param text    "Sending fall.rec"
   * @param failed  begins the notice: "fall.rec is not played: "
   */
  async run<T>(text: string, failed: string, work: (options: TransferOptions) => Promise<T>): Promise<T | undefined> {
    if (this.running) {
      this.notices.notify('error', `${failed}another file is being transferred. Wait for it, or cancel it`);
      return undefined;
    }
    const running = new AbortController();
    this.running = running;
    const startMs = performance.now();
    const onProgress = (part: number) => {
      if (performance.now() - startMs > kShownAfterMs) this.show(text, part);
    };
    try {
      return await work({ signal: running.signal, onProgress });
    } catch (error) {
      if (running.signal.aborted) this.notices.notify('info', `${failed}it was cancelled`);
      else this.notices.notify('error', `${failed}${errorText(error as Error)}`);
      return undefined;
    } finally {
      this.running = undefined;
      this.chip.hidden = true;
    }
  }

  private show(text: string, part: number): void {
    this.chip.hidden = false;
    setText(element('transfer-text'), text);
    // All of it is there: now the server is at work, and nobody knows for how long.
    if (part < 1) this.progress.value = part;
    else this.progress.removeAttribute('value');
  }
}
