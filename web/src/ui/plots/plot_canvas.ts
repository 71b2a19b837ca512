import { niceTicks } from './plot_series';
import type { PlotSeries } from './plot_series';
import { valueText } from './quantities';

/** The looks of a series. */
export interface PlotStyle {
  /** CSS colours of lines, one for each value of a sample; of text; of the grid. */
  colors: readonly string[];
  ink: string;
  grid: string;
  /** Factor on values, and the unit of what that gives. */
  scale: number;
  unit: string;
  /** Simulated seconds of a tick. */
  tickS: number;
  /** Index of the sample that is pointed at; undefined: none. */
  marked: number | undefined;
}

const kLeft = 58;
const kBottom = 18;
const kTop = 6;
const kRight = 8;

/** Returns the time in seconds at which a plot begins and ends. */
function spanOf({ ticks }: PlotSeries, tickS: number): [from: number, to: number] {
  const [first, last] = [ticks[0] * tickS, ticks[ticks.length - 1] * tickS];
  return last > first ? [first, last] : [first, first + tickS];
}

/** Draws series over time with both axes. */
export class PlotCanvas {
  private readonly context: CanvasRenderingContext2D;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.context = canvas.getContext('2d')!;
  }

  draw(series: PlotSeries, style: PlotStyle): void {
    const { canvas, context } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    canvas.width = Math.round(width * devicePixelRatio);
    canvas.height = Math.round(height * devicePixelRatio);
    const range = series.range;
    if (!range || width === 0) return;
    context.scale(devicePixelRatio, devicePixelRatio);
    context.font = '11px system-ui, sans-serif';
    const [from, to] = spanOf(series, style.tickS);
    const [low, high] = widened(style.scale * range[0], style.scale * range[1]);
    const x = (seconds: number) => kLeft + ((seconds - from) / (to - from)) * (width - kLeft - kRight);
    const y = (value: number) => height - kBottom - ((value - low) / (high - low)) * (height - kBottom - kTop);
    this.drawAxes(style, [from, to], [low, high], x, y);
    this.drawLines(series, style, x, y);
    if (style.marked === undefined) return;
    const at = x(series.ticks[style.marked] * style.tickS);
    context.strokeStyle = style.ink;
    context.lineWidth = 1;
    this.line(at, kTop, at, height - kBottom);
  }

  /** Returns the time, seconds, at a place on the canvas, CSS pixels from its left. */
  timeAt(series: PlotSeries, tickS: number, px: number): number {
    const [from, to] = spanOf(series, tickS);
    const share = (px - kLeft) / Math.max(1, this.canvas.clientWidth - kLeft - kRight);
    return from + Math.min(1, Math.max(0, share)) * (to - from);
  }

  private drawAxes(
    { ink, grid, unit }: PlotStyle,
    times: [number, number],
    values: [number, number],
    x: (seconds: number) => number,
    y: (value: number) => number,
  ): void {
    const { context } = this;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    context.lineWidth = 1;
    context.fillStyle = ink;
    context.textBaseline = 'middle';
    context.textAlign = 'right';
    for (const value of niceTicks(...values, 3)) {
      context.strokeStyle = grid;
      this.line(kLeft, y(value), width - kRight, y(value));
      context.fillText(valueText(value, unit), kLeft - 6, y(value));
    }
    context.textBaseline = 'alphabetic';
    const ticks = niceTicks(...times, 4);
    ticks.forEach((seconds, i) => {
      context.strokeStyle = grid;
      this.line(x(seconds), kTop, x(seconds), height - kBottom);
      context.textAlign = x(seconds) > width - 30 ? 'right' : 'center';
      const text = `${seconds.toLocaleString('en')}${i === ticks.length - 1 ? ' s' : ''}`;
      context.fillText(text, Math.min(x(seconds), width - kRight), height - 4);
    });
  }

  private drawLines(
    { ticks, samples, names }: PlotSeries,
    { colors, scale, tickS }: PlotStyle,
    x: (seconds: number) => number,
    y: (value: number) => number,
  ): void {
    const { context } = this;
    context.lineWidth = 1.6;
    context.lineJoin = 'round';
    names.forEach((_, k) => {
      context.strokeStyle = colors[k % colors.length];
      context.beginPath();
      let isDown = false;
      samples.forEach((sample, i) => {
        const value = scale * sample[k];
        if (!Number.isFinite(value)) {
          isDown = false;
          return;
        }
        const [px, py] = [x(ticks[i] * tickS), y(value)];
        if (isDown) context.lineTo(px, py);
        else context.moveTo(px, py);
        isDown = true;
      });
      context.stroke();
    });
  }

  private line(x0: number, y0: number, x1: number, y1: number): void {
    this.context.beginPath();
    this.context.moveTo(x0, y0);
    this.context.lineTo(x1, y1);
    this.context.stroke();
  }
}

/** Returns a range with some room, also for values that are all the same. */
export function widened(low: number, high: number): [low: number, high: number] {
  const span = high - low;
  const least = 1e-6 * Math.max(Math.abs(low), Math.abs(high));
  if (span > least) return [low - 0.06 * span, high + 0.06 * span];
  const room = Math.abs(low) > 0 ? 0.1 * Math.abs(low) : 1;
  return [low - room, high + room];
}
