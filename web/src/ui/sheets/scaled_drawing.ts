import type { Outline } from './new_sheet';
import type { OutlineParts } from './outline_parts';

const kMillimetresPerMetre = 1000;

/**
 * Scales the drawing so that its page is `widthM` wide, and returns its height.
 * @throws Error with a text for people, if the drawing does not state the width of its page
 */
export function scaledOutline({ border, holes }: OutlineParts, widthM: number): Outline {
  // Border and holes have the same page, so heightM is the same.
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

// Returns the viewBox of a page whose size is in pixels, as shapes are. For other units the scale would be unknown.
function pageBox(root: Element): string {
  const size = ['width', 'height'].map((name) => /^\s*([\d.]+)(px)?\s*$/.exec(root.getAttribute(name) ?? '')?.[1]);
  return `0 0 ${size[0]} ${size[1]}`;
}
