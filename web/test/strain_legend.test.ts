import { describe, expect, it } from 'vitest';
import { drawStrainLegend } from '../src/scene/strain_legend';

// Writes down what is drawn, in pixels of the picture.
class FakeContext {
  readonly boxes: [fill: unknown, left: number, top: number, right: number, bottom: number][] = [];
  readonly texts: [text: string, align: string, x: number, y: number][] = [];
  readonly stops: [at: number, color: string][] = [];
  fillStyle: unknown;
  font = '';
  textAlign = '';
  textBaseline = '';
  private ratio = 1;

  save(): void {}

  restore(): void {
    this.ratio = 1;
  }

  scale(ratio: number): void {
    this.ratio *= ratio;
  }

  createLinearGradient(): { addColorStop(at: number, color: string): void } {
    return { addColorStop: (at, color) => void this.stops.push([at, color]) };
  }

  fillRect(x: number, y: number, width: number, height: number): void {
    const [left, top, right, bottom] = [x, y, x + width, y + height].map((px) => px * this.ratio);
    this.boxes.push([this.fillStyle, left, top, right, bottom]);
  }

  fillText(text: string, x: number, y: number): void {
    this.texts.push([text, this.textAlign, x * this.ratio, y * this.ratio]);
  }
}

describe('drawStrainLegend', () => {
  it.each([1, 2])('draws the scale with what stands at its ends into a picture, %i pixels a CSS pixel', (ratio) => {
    const context = new FakeContext();
    const legend = { texts: ['not stretched', '2 % or more'], ink: 'black', card: 'white', fontFamily: 'serif' } as const;
    drawStrainLegend(context as unknown as CanvasRenderingContext2D, legend, 600 * ratio, ratio);
    const [[, left, top, right, bottom], [, from, , to]] = context.boxes;
    expect([left, bottom]).toEqual([12 * ratio, 588 * ratio]);
    expect(from > left && to < right && to - from === 200 * ratio).toBe(true);
    expect(context.stops[0]).toEqual([0, 'rgb(68,1,84)']);
    expect(context.stops.at(-1)).toEqual([1, 'rgb(253,231,37)']);
    const [, , , below] = context.texts[0];
    expect(context.texts).toEqual([
      ['not stretched', 'left', from, below],
      ['2 % or more', 'right', to, below],
    ]);
    expect(below > top && below < bottom).toBe(true);
  });
});
