import type { SampleWindow } from '../stream/sample_window';

/** A small plot of the numbers in a SampleWindow over time, from 0 to the largest; the newest is at the right end. */
export class Sparkline {
  private readonly context: CanvasRenderingContext2D;

  /** @param canvas  canvas whose CSS size and colour the plot takes */
  constructor(private readonly canvas: HTMLCanvasElement) {
    this.context = canvas.getContext('2d')!;
  }

  draw(samples: SampleWindow, nowMs: number): void {
    const { canvas, context } = this;
    const width = Math.round(canvas.clientWidth * devicePixelRatio);
    const height = Math.round(canvas.clientHeight * devicePixelRatio);
    // Setting the size also clears the canvas.
    canvas.width = width;
    canvas.height = height;
    if (samples.count === 0) return;
    const top = Math.max(samples.max(), Number.MIN_VALUE);
    context.strokeStyle = getComputedStyle(canvas).color;
    context.lineWidth = devicePixelRatio;
    context.lineJoin = 'round';
    const room = height - 2 * context.lineWidth;
    context.beginPath();
    samples.forEach((atMs, value) => {
      const x = width * (1 - (nowMs - atMs) / samples.spanMs);
      context.lineTo(x, context.lineWidth + room * (1 - value / top));
    });
    context.stroke();
  }
}
