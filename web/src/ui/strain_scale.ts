import { kStrainGradient, strainTicks } from '../scene/strain_colors';
import type { StrainLegend } from '../scene/strain_legend';
import { element, make, setText } from './dom';

/** Words for the scale's ends. */
const kWords = ['compressed', 'stretched'] as const;

/** The card that explains the colours by strain. */
export class StrainScale {
  private readonly card = element('strain-legend');
  private readonly scale = element('strain-scale');
  private readonly ticks = element('strain-ticks');
  private readonly missing = element('strain-missing');
  private end = 0;

  constructor() {
    element('strain-gradient').style.background = kStrainGradient;
    kWords.forEach((word, i) => setText(element(i === 0 ? 'strain-least' : 'strain-most'), word));
  }

  setShown(isShown: boolean): void {
    this.card.hidden = !isShown;
  }

  /** @param end  strain at the end of the scale, -, > 0: the last colour stands for this stretch and more */
  show(end: number): void {
    this.scale.hidden = false;
    this.missing.hidden = true;
    if (end === this.end) return;
    this.end = end;
    this.ticks.replaceChildren(
      ...strainTicks(end).map(({ at, text }) => {
        const tick = make('li', { textContent: text });
        tick.style.left = `${100 * at}%`;
        return tick;
      }),
    );
  }

  /** Shows that the sheet has no strains. */
  showMissing(): void {
    this.scale.hidden = true;
    this.missing.hidden = false;
  }

  /** The legend that the page shows; undefined if it shows no scale. */
  get legend(): StrainLegend | undefined {
    if (this.card.hidden || this.scale.hidden || this.end === 0) return undefined;
    const { color, backgroundColor, fontFamily } = getComputedStyle(this.card);
    return { ticks: strainTicks(this.end), words: kWords, ink: color, card: backgroundColor, fontFamily };
  }
}
