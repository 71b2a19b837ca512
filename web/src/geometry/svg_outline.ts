import type { Point2 } from './locator';
import { countSegments, pathLines } from './path_lines';

/** The outlines of a drawing for a preview, in a box of their own: x and y (up) in 0..1. */
export interface SvgOutline {
  lines: readonly (readonly Point2[])[];
  /** Width over height of that box, > 0. */
  aspect: number;
}

const kSvg = 'http://www.w3.org/2000/svg';
// Beyond these a preview leaves out the rest; the server cuts it all.
const kMaxElements = 5000;
const kMaxDepth = 64;
const kMaxSamples = 20_000;
const kMaxPieces = 16;
// Chords of what has no corners but its own.
const kShapeSamples = 192;
// px, of the hidden element that the drawing is measured in: what percentages are of.
const kHostSize = 1000;

const kShapes = new Set(['path', 'rect', 'circle', 'ellipse', 'line', 'polyline', 'polygon']);
const kGroups = new Set(['svg', 'g', 'a', 'switch']);
const kCopied = (
  'transform d points x y width height rx ry cx cy r x1 y1 x2 y2 viewBox preserveAspectRatio pathLength'
).split(' ');

/**
 * What the browser makes of a drawing: its own SVG engine places and measures the shapes. Only their geometry is copied
 * into the page: no style, no script, nothing that loads. Undefined without a shape, or if the text is no SVG.
 */
export function svgOutline(text: string): SvgOutline | undefined {
  const parsed = new DOMParser().parseFromString(text, 'image/svg+xml');
  if (parsed.documentElement.localName !== 'svg') return undefined;
  const host = document.createElementNS(kSvg, 'svg');
  host.setAttribute('width', String(kHostSize));
  host.setAttribute('height', String(kHostSize));
  Object.assign(host.style, { position: 'fixed', left: '0', top: '0', visibility: 'hidden', pointerEvents: 'none' });
  document.body.append(host);
  try {
    new Copier(parsed).copy(parsed.documentElement, host, 0);
    return inUnitBox(sample(host));
  } finally {
    host.remove();
  }
}

function isHidden(element: Element): boolean {
  const { style } = element as SVGElement;
  const value = (name: string) => style?.getPropertyValue(name) || element.getAttribute(name);
  return value('display') === 'none' || ['hidden', 'collapse'].includes(value('visibility') ?? '');
}

class Copier {
  private copied = 0;

  constructor(private readonly from: Document) {}

  copy(element: Element, into: Element, depth: number): void {
    const name = element.localName;
    if (element.namespaceURI !== kSvg || depth > kMaxDepth || isHidden(element)) return;
    if (++this.copied > kMaxElements) return;
    if (name === 'use') return this.expand(element, into, depth);
    if (!kShapes.has(name) && !kGroups.has(name)) return;
    this.children(element, into.appendChild(this.bare(element, name)), depth);
  }

  private children(element: Element, into: Element, depth: number): void {
    for (const child of element.children) this.copy(child, into, depth + 1);
  }

  private bare(element: Element, name: string): Element {
    const made = document.createElementNS(kSvg, name);
    for (const attribute of kCopied) {
      const value = element.getAttribute(attribute);
      if (value !== null) made.setAttribute(attribute, value);
    }
    return made;
  }

  // A reference becomes a group that is moved to where it stands, with a copy of what it refers to.
  private expand(use: Element, into: Element, depth: number): void {
    const href = use.getAttribute('href') ?? use.getAttributeNS('http://www.w3.org/1999/xlink', 'href') ?? '';
    const target = href.startsWith('#') ? this.from.getElementById(href.slice(1)) : null;
    if (!target) return;
    const group = into.appendChild(document.createElementNS(kSvg, 'g'));
    const [x, y] = ['x', 'y'].map((name) => Number.parseFloat(use.getAttribute(name) ?? '0') || 0);
    group.setAttribute('transform', `${use.getAttribute('transform') ?? ''} translate(${x} ${y})`);
    if (target.localName !== 'symbol') return this.copy(target, group, depth + 1);
    const viewport = group.appendChild(this.bare(target, 'svg'));
    for (const name of ['width', 'height']) viewport.setAttribute(name, use.getAttribute(name) ?? '100%');
    this.children(target, viewport, depth + 1);
  }
}

function sample(host: SVGSVGElement): Point2[][] {
  const fromScreen = host.getScreenCTM()?.inverse();
  const shapes = [...host.querySelectorAll<SVGGeometryElement>([...kShapes].join(','))];
  const data = shapes.map((shape) => shape.getAttribute('d') ?? '');
  const segments = data.reduce((sum, text) => sum + countSegments(text), 0);
  const pieces = Math.min(kMaxPieces, Math.max(1, Math.floor(kMaxSamples / Math.max(1, segments))));
  const arc = document.createElementNS(kSvg, 'path');
  host.append(arc);
  const arcPoints = (of: string, count: number) => {
    arc.setAttribute('d', of);
    return equidistant(arc, count);
  };
  return shapes.flatMap((shape, i) => {
    const matrix = shape.getScreenCTM();
    if (!fromScreen || !matrix) return [];
    const toHost = fromScreen.multiply(matrix);
    // The browser measures anything, but a path in a time that grows with all of it for each point.
    const lines =
      shape.localName === 'path' ? pathLines(data[i], pieces, arcPoints) : [equidistant(shape, kShapeSamples)];
    return lines.map((line) => line.map(({ x, y }) => new DOMPoint(x, y).matrixTransform(toHost)));
  });
}

function equidistant(shape: SVGGeometryElement, count: number): Point2[] {
  const length = shape.getTotalLength();
  if (!(length > 0)) return [];
  return Array.from({ length: count + 1 }, (_, i) => shape.getPointAtLength((i / count) * length));
}

/** Undefined without points, or if they take no room in either direction. */
export function inUnitBox(lines: readonly (readonly Point2[])[]): SvgOutline | undefined {
  let [minX, minY, maxX, maxY] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const { x, y } of lines.flat()) {
    [minX, maxX] = [Math.min(minX, x), Math.max(maxX, x)];
    [minY, maxY] = [Math.min(minY, y), Math.max(maxY, y)];
  }
  const larger = Math.max(maxX - minX, maxY - minY);
  if (!(larger > 0)) return undefined;
  // A straight line has a box all the same.
  const [width, height] = [Math.max(maxX - minX, 1e-3 * larger), Math.max(maxY - minY, 1e-3 * larger)];
  return {
    lines: lines.map((line) => line.map(({ x, y }) => ({ x: (x - minX) / width, y: (maxY - y) / height }))),
    aspect: width / height,
  };
}
