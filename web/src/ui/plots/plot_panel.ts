import type { Point2 } from '../../geometry/locator';
import type { Notifier } from '../../notifier';
import type { OpenSheet, ShownState } from '../../sheet/open_sheet';
import type { SheetCopy } from '../../stream/sheet_copy';
import type { ProbeRequest } from '../../stream/watch';
import { pressVerb } from '../../tools/press_verb';
import { element, setText } from '../dom';
import { fileName, saveFile } from '../download';
import type { Panel } from '../side_panels';
import { Plot } from './plot';
import { kQuantities } from './quantities';
import type { PlottedQuantity } from './quantities';

// Least time between two drawings of the plots.
const kDrawPeriodMs = 100;
const kMostPlots = 8;
const kUsualRateHz = 60;

/** The parts of the viewer that plots use. */
export interface PlottingParts {
  readonly live: Pick<OpenSheet, 'sheetName'> & {
    /** Starts another stream of the same sheet, which continues from the present triangles. */
    restart(goesOn: true): void;
  };
  readonly shown: Pick<ShownState, 'surface' | 'sheet'>;
  readonly notices: Notifier;
  /** Lets the next tap choose a point of the sheet. */
  pickPoint(picked: (point: Point2) => void): void;
}

/** Plots quantities of the sheet over time. The server measures them for each frame while there are plots. */
export class PlotPanel implements Panel {
  private readonly list = element('plot-list');
  private readonly choice = element<HTMLSelectElement>('plot-quantity');
  private plots: Plot[] = [];
  private sheetName = '';
  private number = 0;
  private isOpen = false;
  private drawnMs = -Infinity;

  constructor(private readonly parts: PlottingParts) {
    this.choice.replaceChildren(...kQuantities.map(({ id, label }) => new Option(label, id)));
    element('plot-add').addEventListener('click', () => this.choose());
  }

  opened(): void {
    this.isOpen = true;
  }

  closed(): void {
    this.isOpen = false;
  }

  /** True while there are plots, which need every frame. */
  get isOn(): boolean {
    return this.measured.length > 0;
  }

  private get measured(): Plot[] {
    return this.plots.filter(({ hasEnded }) => !hasEnded);
  }

  /** Returns what the stream of a sheet has to measure. Those of another sheet end. */
  probesFor(sheetName: string): ProbeRequest[] {
    if (sheetName !== this.sheetName) this.clear();
    this.sheetName = sheetName;
    return this.measured.map(({ probe }) => probe);
  }

  /** Takes the values of a frame. */
  take(copy: Pick<SheetCopy, 'tick' | 'probeColumns' | 'probeValues'>): void {
    for (const plot of this.plots) plot.take(copy);
  }

  /**
   * Ends the plot because of which a connection was refused, such as one at a point that was cut away. Its values stay.
   * @param why  reason of a lost connection
   */
  lost(why: string): void {
    const [, index] = /probes\[(\d+)\]/.exec(why) ?? [];
    const refused = this.measured[Number(index)];
    if (!refused) return;
    refused.hasEnded = true;
    const reason = why.includes('POINT_OUTSIDE') ? 'its point is not on the sheet any more' : why;
    this.parts.notices.notify('warning', `The plot ended: ${refused.title}: ${reason}`);
    this.parts.live.restart(true);
  }

  /** Draws the plots ten times a second while the panel is open. Call it at each animation frame. */
  update(nowMs: number): void {
    if (!this.isOpen || this.plots.length === 0 || nowMs < this.drawnMs + kDrawPeriodMs) return;
    this.drawnMs = nowMs;
    const tickS = 1 / (this.parts.shown.sheet?.tickRateHz || kUsualRateHz);
    for (const plot of this.plots) plot.draw(tickS);
  }

  private choose(): void {
    const quantity = kQuantities.find(({ id }) => id === this.choice.value) ?? kQuantities[0];
    if (this.plots.length >= kMostPlots) {
      this.parts.notices.notify('info', `There is room for ${kMostPlots} plots: remove one first`);
      return;
    }
    if (!quantity.isAtPoint) return this.add(quantity, undefined);
    setText(element('plot-prompt'), `${pressVerb()} the point on the sheet`);
    this.parts.pickPoint((point) => this.add(quantity, point));
  }

  private add(quantity: PlottedQuantity, point: Point2 | undefined): void {
    setText(element('plot-prompt'), '');
    this.number += 1;
    const plot = new Plot(quantity, `${quantity.id}_${this.number}`, point, {
      onSave: (saved) => this.save(saved),
      onRemove: (removed) => this.remove(removed),
    });
    this.plots.push(plot);
    this.list.append(plot.item);
    this.changed();
  }

  private remove(plot: Plot): void {
    this.plots = this.plots.filter((each) => each !== plot);
    plot.item.remove();
    this.changed();
    element('plot-add').focus();
  }

  private clear(): void {
    for (const { item } of this.plots) item.remove();
    this.plots = [];
    this.showEmpty();
  }

  private changed(): void {
    this.showEmpty();
    this.parts.live.restart(true);
  }

  private showEmpty(): void {
    element('plot-list-empty').hidden = this.plots.length > 0;
  }

  private save(plot: Plot): void {
    const { live, notices, shown } = this.parts;
    const tickS = 1 / (shown.sheet?.tickRateHz || kUsualRateHz);
    const { id, scale, unit } = plot.quantity;
    const csv = plot.series.csv(id, tickS, scale, unit);
    const name = fileName(live.sheetName, plot.series.ticks.at(-1) ?? 0, `${id}.csv`);
    notices.notify('success', saveFile([csv], name, 'text/csv'));
  }
}
