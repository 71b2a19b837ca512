import { kStrainStops } from './strain_colors';
import type { StrainTick } from './strain_colors';

/** The page's legend of the colours by strain. */
export interface StrainLegend {
  ticks: readonly StrainTick[];
  /** Words for the scale's ends, such as "compressed". */
  words: readonly [left: string, right: string];
  /** CSS colours. */
  ink: string;
  card: string;
  fontFamily: string;
}

// CSS pixels.
const kMargin = 12;
const kPadding = { side: 26, end: 8 };
const kScale = { width: 200, height: 10 };
const kFontSize = 12;
const kLine = kFontSize + 4;
const kTick = 4;
const kHeight = 2 * kPadding.end + kLine + kScale.height + kTick + kLine;

/**
 * Draws the legend in the lower left corner.
 * @param context  context of a picture with `ratio` pixels per CSS pixel
 * @param height   height of the picture, pixels
 */
export function drawStrainLegend(
  context: CanvasRenderingContext2D,
  { ticks, words, ink, card, fontFamily }: StrainLegend,
  height: number,
  ratio: number,
): void {
  const top = height / ratio - kMargin - kHeight;
  const left = kMargin + kPadding.side;
  const scaleTop = top + kPadding.end + kLine;
  context.save();
  context.scale(ratio, ratio);
  context.fillStyle = card;
  context.fillRect(kMargin, top, kScale.width + 2 * kPadding.side, kHeight);
  const gradient = context.createLinearGradient(left, 0, left + kScale.width, 0);
  kStrainStops.forEach((color, i) => gradient.addColorStop(i / (kStrainStops.length - 1), color));
  context.fillStyle = gradient;
  context.fillRect(left, scaleTop, kScale.width, kScale.height);
  context.fillStyle = ink;
  context.font = `${kFontSize}px ${fontFamily}`;
  context.textBaseline = 'bottom';
  (['left', 'right'] as const).forEach((side, i) => {
    context.textAlign = side;
    context.fillText(words[i], left + i * kScale.width, scaleTop - 2);
  });
  context.textAlign = 'center';
  for (const { at, text } of ticks) {
    const x = left + at * kScale.width;
    context.fillRect(x - 0.5, scaleTop + kScale.height, 1, kTick);
    context.fillText(text, x, top + kHeight - kPadding.end);
  }
  context.restore();
}
