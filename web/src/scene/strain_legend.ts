import { kStrainStops } from './strain_colors';

/** The page's legend of the colours by strain. */
export interface StrainLegend {
  /** At the ends of the scale. */
  readonly texts: readonly [least: string, most: string];
  /** CSS colours. */
  readonly ink: string;
  readonly card: string;
  readonly fontFamily: string;
}

// CSS pixels.
const kMargin = 12;
const kPadding = 12;
const kScale = { width: 200, height: 10 };
const kFontSize = 12;
const kHeight = 2 * kPadding + kScale.height + kFontSize + 4;

/**
 * Draws it in the lower left corner.
 * @param context  of a picture with `ratio` pixels a CSS pixel
 * @param height   of the picture, pixels
 */
export function drawStrainLegend(
  context: CanvasRenderingContext2D,
  { texts, ink, card, fontFamily }: StrainLegend,
  height: number,
  ratio: number,
): void {
  const top = height / ratio - kMargin - kHeight;
  const left = kMargin + kPadding;
  context.save();
  context.scale(ratio, ratio);
  context.fillStyle = card;
  context.fillRect(kMargin, top, kScale.width + 2 * kPadding, kHeight);
  const gradient = context.createLinearGradient(left, 0, left + kScale.width, 0);
  kStrainStops.forEach((color, i) => gradient.addColorStop(i / (kStrainStops.length - 1), color));
  context.fillStyle = gradient;
  context.fillRect(left, top + kPadding, kScale.width, kScale.height);
  context.fillStyle = ink;
  context.font = `${kFontSize}px ${fontFamily}`;
  context.textBaseline = 'bottom';
  (['left', 'right'] as const).forEach((side, i) => {
    context.textAlign = side;
    context.fillText(texts[i], left + i * kScale.width, top + kHeight - kPadding);
  });
  context.restore();
}
