import type { Measured } from '../tools/measure_tool';
import { measureAreaText, measureText, measureUnit, stretchText } from '../tools/measures';
import { pressVerb } from '../tools/press_verb';
import { element, setText } from './dom';

/** Says what to do next, or why there are no numbers. */
export function measurePrompt({ numPoints, isGone }: Pick<Measured, 'numPoints' | 'isGone'>): string {
  if (isGone) return 'The sheet was cut away at a point: set it again';
  if (numPoints === 0) return `${pressVerb()} two points of the sheet`;
  return numPoints === 1 ? `${pressVerb()} the second point` : 'Drag the points, or set others';
}

/** Shows what the measuring tool has measured. */
export class MeasurePanel {
  private readonly panel = element('measure-panel');

  setShown(isShown: boolean): void {
    this.panel.hidden = !isShown;
  }

  show(measured: Measured): void {
    const { line, piece } = measured;
    const unit = measureUnit(line, piece);
    setText(element('measure-prompt'), measurePrompt(measured));
    const set = (id: string, text: string) => {
      setText(element(`measure-${id}`), text);
      element(`measure-${id}`).parentElement!.hidden = text === '';
    };
    set('space', line ? measureText(line.spaceM, unit) : '');
    set('sheet', line ? measureText(line.sheetM, unit) : '');
    set('stretch', line ? stretchText(line) : '');
    set('rest', piece ? measureAreaText(piece.restM2, unit) : '');
    set('now', piece ? measureAreaText(piece.nowM2, unit) : '');
  }
}
