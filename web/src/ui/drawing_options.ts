import type { Reporter } from '../notifier';
import type { PictureDrawing } from '../tools/drawings/picture_drawing';
import { readPicture, reportText } from '../tools/drawings/picture_reader';
import { element, make, setText } from './dom';

/** The tool whose drawing the options are about. */
export interface DrawingHolder {
  /** The drawing from a file that lies on the sheet; undefined if there is none. */
  readonly laid: PictureDrawing | undefined;
  /** Shows the drawing again after it was changed. */
  redraw(): void;
}

/** Says what a drawing from a file has, and lets the user choose a colour, layer or class of it and its true size. */
export class DrawingOptions {
  private readonly box = element('cut-drawing');
  private readonly summary = element('cut-drawing-text');
  private readonly only = element<HTMLSelectElement>('cut-drawing-only');
  private readonly trueSize = element<HTMLButtonElement>('cut-drawing-true-size');
  private shown: PictureDrawing | undefined;

  /** @param done  returns the keyboard focus to the canvas */
  constructor(
    private readonly holder: DrawingHolder,
    private readonly notices: Reporter,
    done: () => void,
  ) {
    this.only.addEventListener('change', () => void this.choose(this.only.value).then(done));
    this.trueSize.addEventListener('click', () => {
      holder.laid?.takeTrueSize();
      holder.redraw();
      done();
    });
  }

  update(): void {
    const { laid } = this.holder;
    const report = laid?.report;
    this.box.hidden = report === undefined;
    if (!laid || !report || laid === this.shown) return;
    this.shown = laid;
    this.showReport();
  }

  private showReport(): void {
    const { report, only } = this.shown!;
    setText(this.summary, reportText(report!));
    // The choices are those of the whole drawing, also while a part is chosen.
    const choices = report!.groups.filter(({ shapes }) => shapes > 0).map(({ selector }) => selector);
    this.only.replaceChildren(
      make('option', { value: '', textContent: 'all of it' }),
      ...choices.map((selector) => make('option', { value: selector, textContent: selector.replace('=', ' ') })),
    );
    this.only.value = only;
  }

  private async choose(only: string): Promise<void> {
    const { laid } = this.holder;
    if (!laid?.picture?.content) return;
    const { name, content } = laid.picture;
    const picture = await this.notices.attempt(() => readPicture(name, content, only), `${name}: `);
    if (!picture || this.holder.laid !== laid) return;
    laid.replace(picture);
    this.shown = laid;
    this.showReport();
    this.holder.redraw();
  }
}
