import type { Outline } from './new_sheet';
import type { OutlineParts } from './outline_parts';

const kMillimetresPerMetre = 1000;

/**
 * The drawing with its page made `widthM` wide, as high as it then is.
 * @throws Error in words for people: nothing says how wide its page is
 */
export function scaledOutline({ border, holes }: OutlineParts, widthM: number): Outline {
  // Both have the same page.
  const { text, heightM } = scaledDrawing(border, widthM);
  return { text, heightM, holes: holes && scaledDrawing(holes, widthM).text };
}

function scaledDrawing(text: string, widthM: number): { text: string; heightM: number } {
  const parsed = new DOMParser().parseFromString(text, 'image/svg+xml');
  const root = parsed.documentElement;
  const box = (root.getAttribute('viewBox') ?? pageBox(root)).trim().split(/[\s,]+/).map(Number);
  const [, , width, height] = box;
  if (box.length !== 4 || !box.every(Number.isFinite) || width <= 0 || height <= 0) {
    throw new Error('does not say how large its page is: give its svg element a viewBox, or a width and a height');
  }
  const heightM = (widthM * height) / width;
  root.setAttribute('viewBox', box.join(' '));
  root.setAttribute('width', `${kMillimetresPerMetre * widthM}mm`);
  root.setAttribute('height', `${kMillimetresPerMetre * heightM}mm`);
  return { text: new XMLSerializer().serializeToString(parsed), heightM };
}

// Shapes are in pixels: a page in other units without a viewBox does not say how they fit on it.
function pageBox(root: Element): string {
  const size = ['width', 'height'].map((name) => /^\s*([\d.]+)(px)?\s*$/.exec(root.getAttribute(name) ?? '')?.[1]);
  return `0 0 ${size[0]} ${size[1]}`;
}
