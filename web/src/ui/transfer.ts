import type { TransferOptions } from '../api';
import type { Notifier } from '../notifier';
import { element, setText } from './dom';
import { errorText } from './error_text';

// Delay before a transfer is shown; a shorter one would be over before anyone could read about it.
const kShownAfterMs = 200;

/**
 * Transfers a file to or from the server, one at a time. A long transfer is shown in the header, where it can be
 * cancelled.
 */
export class Transfer {
  private readonly chip = element('transfer');
  private readonly progress = element<HTMLProgressElement>('transfer-progress');
  private running: AbortController | undefined;

  constructor(private readonly notices: Notifier) {
    element('transfer-cancel').addEventListener('click', () => this.running?.abort());
  }

  get isOn(): boolean {
    return this.running !== undefined;
  }

  /**
   * Runs `work` and returns its result. If it failed or was cancelled, shows a notice and returns undefined.
   * @param text    "Sending fall.rec"
   * @param failed  beginning of the notice: "fall.rec is not played: "
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
    // Once all is sent, the server works for an unknown time.
    if (part < 1) this.progress.value = part;
    else this.progress.removeAttribute('value');
  }
}
