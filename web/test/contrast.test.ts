import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';

type Rgba = [red: number, green: number, blue: number, alpha: number];

const css = readFileSync(new URL('../src/style/base.css', import.meta.url), 'utf8');

function parse(text: string): Rgba {
  const hex = /^#([\da-f]{6})$/i.exec(text);
  if (hex) return [0, 2, 4].map((at) => parseInt(hex[1].slice(at, at + 2), 16)).concat(1) as Rgba;
  const rgb = /^rgb\((\d+) (\d+) (\d+) \/ ([\d.]+)\)$/.exec(text);
  if (!rgb) throw new Error(`no colour: ${text}`);
  return rgb.slice(1).map(Number) as Rgba;
}

/** Both colours of a variable of :root. */
function pair(name: string): { light: Rgba; dark: Rgba } {
  const found = new RegExp(`--${name}: light-dark\\((#\\w+|rgb\\([^)]+\\)), (#\\w+|rgb\\([^)]+\\))\\);`).exec(css);
  if (!found) throw new Error(`base.css has no --${name}`);
  return { light: parse(found[1]), dark: parse(found[2]) };
}

function over([r, g, b, a]: Rgba, [R, G, B]: Rgba): Rgba {
  return [r * a + R * (1 - a), g * a + G * (1 - a), b * a + B * (1 - a), 1];
}

// WCAG 2.2, relative luminance and contrast ratio.
function luminance([red, green, blue]: Rgba): number {
  const linear = [red, green, blue].map((value) => {
    const c = value / 255;
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
}

function contrast(a: Rgba, b: Rgba): number {
  const [dark, light] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (light + 0.05) / (dark + 0.05);
}

// The worst colour of the scene behind a card: in the light the darkest, in the dark the lightest.
const kBehind = { light: parse('#000000'), dark: parse('#ffffff') };

describe.each(['light', 'dark'] as const)('the %s theme', (theme) => {
  const color = (name: string) => pair(name)[theme];
  const card = over(color('card'), kBehind[theme]);

  it.each(['ink', 'ink-soft', 'accent', 'good', 'warn', 'bad'])('reads %s on a card and on what is hovered over', (name) => {
    expect(contrast(color(name), card)).toBeGreaterThanOrEqual(4.5);
    expect(contrast(color(name), over(color('hover'), card))).toBeGreaterThanOrEqual(4.5);
  });

  it('reads buttons that are pressed', () => {
    expect(contrast(color('on-accent'), color('accent'))).toBeGreaterThanOrEqual(4.5);
  });

  it.each(['sky-top', 'sky-bottom'])('reads text on the bare page, %s', (sky) => {
    expect(contrast(color('ink'), color(sky))).toBeGreaterThanOrEqual(4.5);
  });

  it('shows where fields and the focus are: 3 to 1', () => {
    expect(contrast(color('field-edge'), card)).toBeGreaterThanOrEqual(3);
    expect(contrast(color('accent'), color('sky-bottom'))).toBeGreaterThanOrEqual(3);
  });
});

describe('contrast', () => {
  it('is 21 of black on white and 4.48 of the known grey', () => {
    expect(contrast(parse('#000000'), parse('#ffffff'))).toBeCloseTo(21, 10);
    expect(contrast(parse('#777777'), parse('#ffffff'))).toBeCloseTo(4.48, 2);
  });
});
