import type { FrameStats } from '../gen/kerf/v1/stream_pb';
import type { SheetFigures } from '../stream/sheet_copy';
import { StreamMeter } from '../stream/stream_meter';
import type { Delivery } from '../stream/stream_meter';
import type { SampleWindow } from '../stream/sample_window';
import { element, setText } from './dom';
import { Sparkline } from './sparkline';
import { kStatistics, statisticsTexts } from './statistics_text';
import type { StatisticId } from './statistics_text';

const kUpdateEveryMs = 250;

/** The overlay with figures of the stream and the sheet. While it is hidden nothing is measured. */
export class StatisticsPanel {
  private readonly panel = element('statistics');
  private readonly button = element('statistics-toggle');
  private readonly meter = new StreamMeter();
  private readonly values = new Map<StatisticId, HTMLElement>();
  private readonly plots: [Sparkline, SampleWindow][] = [];
  private updatedMs = Number.NEGATIVE_INFINITY;

  constructor() {
    const list = document.createElement('dl');
    const plotted: Partial<Record<StatisticId, SampleWindow>> = {
      age: this.meter.ages,
      bytes: this.meter.bytes,
      tick: this.meter.tickTimes,
    };
    for (const [id, [label, meaning]] of Object.entries(kStatistics) as [StatisticId, readonly [string, string]][]) {
      const row = document.createElement('div');
      const name = document.createElement('dt');
      const value = document.createElement('dd');
      row.title = meaning;
      name.textContent = label;
      row.append(name, value);
      list.append(row);
      this.values.set(id, value);
      const samples = plotted[id];
      if (samples) this.addPlot(row, label, samples);
    }
    this.panel.append(list);
  }

  get isShown(): boolean {
    return !this.panel.hidden;
  }

  toggle(): void {
    this.panel.hidden = this.isShown;
    this.button.setAttribute('aria-pressed', String(this.isShown));
    this.reset();
  }

  /** Drops all measurements, for a new stream. */
  reset(): void {
    this.meter.clear();
    this.updatedMs = Number.NEGATIVE_INFINITY;
  }

  arrived(delivery: Delivery, stats: FrameStats | undefined): void {
    if (!this.isShown) return;
    const figures = stats && { skipped: Number(stats.skipped), tickCpuUs: stats.tickCpuUs };
    this.meter.arrived(performance.now(), delivery, figures);
  }

  /** @param ageMs  see StreamMeter.wasDrawn() */
  drawn(nowMs: number, ageMs: number | undefined): void {
    if (this.isShown) this.meter.wasDrawn(nowMs, ageMs);
  }

  /** @param format  format of the stream, for people */
  update(sheet: SheetFigures | undefined, format: string, nowMs: number): void {
    if (!this.isShown || nowMs - this.updatedMs < kUpdateEveryMs) return;
    this.updatedMs = nowMs;
    this.meter.forget(nowMs);
    const texts = statisticsTexts(this.meter, sheet, format, nowMs);
    for (const [id, value] of this.values) setText(value, texts[id] ?? '–');
    for (const [plot, samples] of this.plots) plot.draw(samples, nowMs);
  }

  private addPlot(row: HTMLElement, label: string, samples: SampleWindow): void {
    const canvas = document.createElement('canvas');
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', `${label}, the last ${this.meter.spanMs / 1000} seconds`);
    const plot = document.createElement('dd');
    plot.className = 'plot';
    plot.append(canvas);
    row.append(plot);
    this.plots.push([new Sparkline(canvas), samples]);
  }
}
