import { kLeastWeight } from '../tools/cut_tool';
import type { CutTool } from '../tools/cut_tool';
import type { CutMode } from '../tools/drawings/kinds';
import type { CutTarget } from '../tools/drawing_plane';
import { Choice, element, setText } from './dom';

const kMillimetre = 1e-3;

/** Choice of drawing and target, prompt and buttons of the cut tool. */
export class CutPanel {
  private readonly panel = element('cut-panel');
  private readonly prompt = element('cut-prompt');
  private readonly warning = element('cut-warning');
  private readonly apply = element<HTMLButtonElement>('cut-apply');
  private readonly again = element<HTMLButtonElement>('cut-again');
  private readonly cancel = element<HTMLButtonElement>('cut-cancel');
  private readonly target = element<HTMLSelectElement>('cut-target');
  private readonly depthOptions = element('cut-depth');
  private readonly nearest = element<HTMLInputElement>('cut-nearest');
  private readonly farthest = element<HTMLInputElement>('cut-farthest');
  private readonly pieceOptions = element('cut-piece');
  private readonly piece = element<HTMLButtonElement>('cut-piece-choose');
  private readonly isDashed = element<HTMLInputElement>('cut-dashed');
  private readonly dashOptions = element('cut-dash');
  private readonly dashCut = element<HTMLInputElement>('cut-dash-cut');
  private readonly dashLeft = element<HTMLInputElement>('cut-dash-left');
  private readonly width = element<HTMLInputElement>('cut-width');
  private readonly weightOptions = element('cut-weight');
  private readonly weight = element<HTMLInputElement>('cut-weight-value');
  private readonly mode: Choice<CutMode>;

  /**
   * @param done        returns the keyboard focus to the canvas
   * @param chooseFile  lets the user choose a file with a drawing
   */
  constructor(
    private readonly tool: CutTool,
    done: () => void,
    chooseFile: () => void,
  ) {
    this.mode = new Choice<CutMode>(this.panel, 'mode', (mode) => {
      tool.setMode(mode);
      if (mode === 'svg') chooseFile();
    });
    this.apply.addEventListener('click', () => void tool.cut());
    this.again.addEventListener('click', () => tool.again());
    this.cancel.addEventListener('click', () => tool.cancel());
    this.piece.addEventListener('click', () => tool.choosePiece());
    this.target.addEventListener('change', () => {
      tool.setTarget(this.target.value as CutTarget);
      done();
    });
    this.isDashed.addEventListener('change', () => {
      tool.setDashes({ isOn: this.isDashed.checked });
      done();
    });
    whenNumber(this.nearest, (nearestM) => tool.setDepth({ nearestM }));
    whenNumber(this.farthest, (farthestM) => tool.setDepth({ farthestM }));
    whenNumber(this.dashCut, (mm) => tool.setDashes({ cutM: mm * kMillimetre }));
    whenNumber(this.dashLeft, (mm) => tool.setDashes({ leftM: mm * kMillimetre }));
    whenNumber(this.width, (mm) => tool.setWidth(mm * kMillimetre));
    // Typed values take effect at once; these keys leave the field.
    element('cut-options').addEventListener('keydown', ({ key }) => {
      if (key === 'Enter' || key === 'Escape') done();
    });
    // The slider's values are logarithms of weights.
    this.weight.min = String(Math.log10(kLeastWeight));
    this.weight.max = String(-Math.log10(kLeastWeight));
    whenNumber(this.weight, (exponent) => tool.setWeight(10 ** exponent));
  }

  /** Moves the keyboard focus to the field of the width. */
  askWidth(): void {
    this.width.focus();
    this.width.select();
  }

  update(isShown: boolean): void {
    const { tool } = this;
    this.panel.hidden = !isShown;
    setText(this.prompt, tool.prompt);
    setText(this.warning, tool.warning);
    this.warning.hidden = tool.warning === '';
    this.apply.disabled = !tool.isReady;
    this.again.hidden = !tool.hasLast;
    this.cancel.disabled = !tool.isStarted;
    this.mode.show(tool.mode);
    this.target.value = tool.target;
    this.target.disabled = tool.mode === 'svg';
    this.target.title = tool.mode === 'svg' ? 'A drawing from a file lies on the material' : '';
    this.depthOptions.hidden = tool.target !== 'depth';
    this.pieceOptions.hidden = tool.target !== 'piece';
    setText(element('cut-piece-shown'), tool.hasPiece ? 'the marked one' : 'the one the line meets first');
    setText(this.piece, tool.hasPiece ? 'Forget it' : 'Choose');
    setNumber(this.nearest, tool.depth.nearestM);
    setNumber(this.farthest, tool.depth.farthestM);
    this.isDashed.checked = tool.dashes.isOn;
    this.dashOptions.hidden = !tool.dashes.isOn;
    setNumber(this.dashCut, tool.dashes.cutM / kMillimetre);
    setNumber(this.dashLeft, tool.dashes.leftM / kMillimetre);
    setNumber(this.width, tool.widthM / kMillimetre);
    const { weighted } = tool;
    this.weightOptions.hidden = !weighted;
    if (!weighted) return;
    setText(element('cut-weight-point'), String(weighted.index + 1));
    setText(element('cut-weight-shown'), weighted.weight.toFixed(2));
    setNumber(this.weight, Math.log10(weighted.weight));
  }
}

function whenNumber(input: HTMLInputElement, use: (value: number) => void): void {
  input.addEventListener('input', () => {
    if (Number.isFinite(input.valueAsNumber)) use(input.valueAsNumber);
  });
}

// Shows a number, except while the field is typed into, or if the number differs only by rounding.
function setNumber(input: HTMLInputElement, value: number): void {
  if (document.activeElement === input && input.type === 'number') return;
  const text = String(Number(value.toFixed(4)));
  if (input.value !== text) input.value = text;
}
