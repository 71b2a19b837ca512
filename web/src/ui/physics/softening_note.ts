import type { Sheet, Softening } from '../../gen/kerf/v1/sheets_pb';
import { element, setText } from '../dom';

// Rounds to two digits, because the error is an estimate.
function millimetresText(metres: number): string {
  return `${(1e3 * metres).toLocaleString('en', { maximumSignificantDigits: 2 })} mm`;
}

/** Says how much softer than its material a sheet is, and the error to expect; empty if it is not softened. */
export function softeningText(softening: Softening | undefined): string {
  if (!softening || softening.factor <= 1) return '';
  const { factor, fits, expectedErrorM } = softening;
  const sentences = [
    `Softened for real time: this sheet is ${factor} times softer in its plane than these numbers say.`,
    `Expected error after 0.3 s: ${millimetresText(expectedErrorM)} if the sheet is flat, without contact, wind, pulls or cuts.`,
  ];
  if (!fits) sentences.push('This is still too much for a tick: use a coarser mesh.');
  return sentences.join(' ');
}

/** Shows below the material that the sheet is softened. */
export class SofteningNote {
  private readonly line = element('material-softening');

  show({ softening }: Sheet): void {
    const text = softeningText(softening);
    setText(this.line, text);
    this.line.hidden = text === '';
  }
}
