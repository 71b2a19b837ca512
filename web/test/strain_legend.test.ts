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
  it.each([1, 2])('draws the scale with its marks and words into a picture, %i pixels a CSS pixel', (ratio) => {
    const context = new FakeContext();
    const ticks = [
      { at: 0, text: '−2' },
      { at: 0.5, text: '0' },
      { at: 1, text: '2 %' },
    ];
    const words = ['compressed', 'stretched'] as const;
    const legend = { ticks, words, ink: 'black', card: 'white', fontFamily: 'serif' };
    drawStrainLegend(context as unknown as CanvasRenderingContext2D, legend, 600 * ratio, ratio);
    const [[, left, top, right, bottom], [, from, , to, scaleBottom], ...marks] = context.boxes;
    expect([left, bottom]).toEqual([12 * ratio, 588 * ratio]);
    expect(from > left && to < right && to - from === 200 * ratio).toBe(true);
    expect(context.stops[0]).toEqual([0, 'rgb(59,76,192)']);
    expect(context.stops.at(-1)).toEqual([1, 'rgb(180,4,38)']);
    const middle = 0.5 * (from + to);
    expect(marks.map(([, at, above, end]) => [0.5 * (at + end), above])).toEqual([
      [from, scaleBottom],
      [middle, scaleBottom],
      [to, scaleBottom],
    ]);
    const [, , , above] = context.texts[0];
    const [, , , below] = context.texts[2];
    expect(context.texts).toEqual([
      ['compressed', 'left', from, above],
      ['stretched', 'right', to, above],
      ['−2', 'center', from, below],
      ['0', 'center', middle, below],
      ['2 %', 'center', to, below],
    ]);
    expect(above > top && below > scaleBottom && below < bottom).toBe(true);
  });
});
