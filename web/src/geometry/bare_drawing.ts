const kSvg = 'http://www.w3.org/2000/svg';
// The server refuses drawings with more elements or deeper nesting; a copy leaves out the rest.
const kMaxElements = 50_000;
const kMaxDepth = 64;
// Size in px of the hidden element in which the drawing is measured; percentages refer to it.
const kHostSize = 1000;

const kShapes = new Set(['path', 'rect', 'circle', 'ellipse', 'line', 'polyline', 'polygon']);
const kGroups = new Set(['svg', 'g', 'a', 'switch']);
const kCopied = (
  'transform d points x y width height rx ry cx cy r x1 y1 x2 y2 viewBox preserveAspectRatio pathLength'
).split(' ');

/**
 * A copy of a drawing in the page: only geometry, without style, scripts and things to load; references are resolved.
 */
export interface BareDrawing {
  /** The hidden element that contains `root`; the browser lays it out. */
  host: SVGSVGElement;
  root: SVGSVGElement;
  /** False if the drawing is too large or too deep, so that a part was left out. */
  isWhole: boolean;
}

/** Copies a drawing into the page, calls `use` and removes the copy. Undefined if the text is no SVG. */
export function withBareDrawing<T>(text: string, use: (drawing: BareDrawing) => T): T | undefined {
  const parsed = new DOMParser().parseFromString(text, 'image/svg+xml');
  if (parsed.documentElement.localName !== 'svg') return undefined;
  const host = document.createElementNS(kSvg, 'svg');
  host.setAttribute('width', String(kHostSize));
  host.setAttribute('height', String(kHostSize));
  Object.assign(host.style, { position: 'fixed', left: '0', top: '0', visibility: 'hidden', pointerEvents: 'none' });
  document.body.append(host);
  try {
    const copier = new Copier(parsed);
    copier.copy(parsed.documentElement, host, 0);
    const root = host.firstElementChild as SVGSVGElement | null;
    return root ? use({ host, root, isWhole: copier.isWhole }) : undefined;
  } finally {
    host.remove();
  }
}

/** Returns the shapes below `root`, in the order in which they are drawn. */
export function shapesIn(root: Element): SVGGeometryElement[] {
  return [...root.querySelectorAll<SVGGeometryElement>([...kShapes].join(','))];
}

function isHidden(element: Element): boolean {
  const { style } = element as SVGElement;
  const value = (name: string) => style?.getPropertyValue(name) || element.getAttribute(name);
  return value('display') === 'none' || ['hidden', 'collapse'].includes(value('visibility') ?? '');
}

class Copier {
  isWhole = true;
  private copied = 0;

  constructor(private readonly from: Document) {}

  copy(element: Element, into: Element, depth: number): void {
    const name = element.localName;
    if (element.namespaceURI !== kSvg || isHidden(element)) return;
    if (++this.copied > kMaxElements || depth > kMaxDepth) return void (this.isWhole = false);
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

  // Replaces a reference (<use>) by a group at its place, with a copy of the element referred to.
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
