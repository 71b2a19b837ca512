import type { Point2 } from '../../geometry/locator';
import type { ProbeRequest } from '../../stream/watch';
import type { SheetCopy } from '../../stream/sheet_copy';
import { icon, make, setText } from '../dom';
import { PlotCanvas } from './plot_canvas';
import { PlotSeries } from './plot_series';
import { probeOf, valueText } from './quantities';
import type { PlottedQuantity } from './quantities';

// A minute of ticks at 60 Hz.
const kMostSamples = 3600;
const kColors = 5;

/** Called by the buttons of a plot. */
export interface PlotEvents {
  onSave(plot: Plot): void;
  onRemove(plot: Plot): void;
}

/** One plot of the panel: a quantity over time, with values, axes and buttons. */
export class Plot {
  readonly item: HTMLElement;
  readonly series = new PlotSeries(kMostSamples);
  /** True if the server refuses to measure it. */
  hasEnded = false;
  private readonly canvas = make('canvas', { role: 'img' });
  private readonly plotted = new PlotCanvas(this.canvas);
  private readonly legend = make('ul', { className: 'plot-legend' });
  private readonly swatches: HTMLElement[] = [];
  private readonly values: HTMLElement[] = [];
  private pointedPx: number | undefined;
  private isStale = true;

  /**
   * @param name   of the probe, unique
   * @param point  material coordinates, metres, if the quantity is at a point
   */
  constructor(
    readonly quantity: PlottedQuantity,
    readonly name: string,
    readonly point: Point2 | undefined,
    events: PlotEvents,
  ) {
    const save = make('button', { type: 'button', title: 'Save the values as CSV' }, 'CSV');
    const label = `Remove the plot: ${this.title}`;
    const remove = make('button', { type: 'button', className: 'icon', title: label, 'aria-label': label }, icon('close'));
    save.setAttribute('aria-label', `Save the values as CSV: ${this.title}`);
    save.addEventListener('click', () => events.onSave(this));
    remove.addEventListener('click', () => events.onRemove(this));
    this.canvas.addEventListener('pointermove', (event) => this.pointAt(event.offsetX));
    this.canvas.addEventListener('pointerleave', () => this.pointAt(undefined));
    const head = make('div', { className: 'plot-head' }, make('b', {}, this.title), save, remove);
    this.item = make('li', {}, head, this.canvas, this.legend);
  }

  /** Title with the place: "Position of a point (0.25, 0.5)". */
  get title(): string {
    const { point, quantity } = this;
    return point ? `${quantity.label} (${point.x.toFixed(3)}, ${point.y.toFixed(3)})` : quantity.label;
  }

  get probe(): ProbeRequest {
    return probeOf(this.quantity, this.name, this.point);
  }

  /** Takes the values of a frame. */
  take({ tick, probeColumns, probeValues }: Pick<SheetCopy, 'tick' | 'probeColumns' | 'probeValues'>): void {
    const own = probeColumns.flatMap((column, i) => (column.startsWith(`${this.name}.`) ? [i] : []));
    if (own.length === 0 || probeValues.length !== probeColumns.length) return;
    const names = own.map((i) => probeColumns[i].slice(this.name.length + 1));
    this.series.add(tick, names, own.map((i) => probeValues[i]));
    this.isStale = true;
  }

  /** Draws it, unless nothing has changed. */
  draw(tickS: number): void {
    if (!this.isStale) return;
    this.isStale = false;
    const { series, quantity } = this;
    while (this.values.length < series.names.length) this.addValue(this.values.length);
    const marked =
      this.pointedPx === undefined || series.ticks.length === 0
        ? undefined
        : series.nearest(this.plotted.timeAt(series, tickS, this.pointedPx) / tickS);
    const shown = series.samples[marked ?? series.samples.length - 1] ?? [];
    series.names.forEach((name, k) => {
      setText(this.values[k], `${name} ${valueText(quantity.scale * (shown[k] ?? NaN), quantity.unit)}`);
    });
    const text = series.names.map((_, k) => this.values[k].textContent).join(', ');
    this.canvas.setAttribute('aria-label', `${this.title} over time: ${text}`);
    const style = getComputedStyle(this.canvas);
    this.plotted.draw(series, {
      colors: this.swatches.map((swatch) => getComputedStyle(swatch).color),
      ink: style.color,
      grid: style.borderTopColor,
      scale: quantity.scale,
      unit: quantity.unit,
      tickS,
      marked,
    });
  }

  private pointAt(px: number | undefined): void {
    this.pointedPx = px;
    this.isStale = true;
  }

  private addValue(k: number): void {
    const swatch = make('i', { 'aria-hidden': 'true', className: `plot-color-${k % kColors}` });
    const value = make('span', {});
    this.swatches.push(swatch);
    this.values.push(value);
    this.legend.append(make('li', {}, swatch, value));
  }
}
