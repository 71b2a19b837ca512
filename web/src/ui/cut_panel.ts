import type { CutMode, CutTool } from '../tools/cut_tool';
import { Choice, element, setText } from './dom';

/** Prompt and buttons of the cut tool. */
export class CutPanel {
  private readonly panel = element('cut-panel');
  private readonly prompt = element('cut-prompt');
  private readonly apply = element<HTMLButtonElement>('cut-apply');
  private readonly cancel = element<HTMLButtonElement>('cut-cancel');
  private readonly mode: Choice<CutMode>;

  constructor(private readonly tool: CutTool) {
    this.mode = new Choice<CutMode>(this.panel, 'mode', (mode) => tool.setMode(mode));
    this.apply.addEventListener('click', () => void tool.cut());
    this.cancel.addEventListener('click', () => tool.cancel());
  }

  update(isShown: boolean): void {
    this.panel.hidden = !isShown;
    setText(this.prompt, this.tool.prompt);
    this.apply.disabled = !this.tool.isReady;
    this.cancel.disabled = !this.tool.isStarted;
    this.mode.show(this.tool.mode);
  }
}
