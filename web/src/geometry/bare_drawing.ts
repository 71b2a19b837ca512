const kSvg = 'http://www.w3.org/2000/svg';
// The server refuses drawings with more elements, or with more of them in one another; a copy leaves out the rest.
const kMaxElements = 50_000;
const kMaxDepth = 64;
// px, of the hidden element that the drawing is measured in: what percentages are of.
const kHostSize = 1000;

const kShapes = new Set(['path', 'rect', 'circle', 'ellipse', 'line', 'polyline', 'polygon']);
const kGroups = new Set(['svg', 'g', 'a', 'switch']);
const kCopied = (
  'transform d points x y width height rx ry cx cy r x1 y1 x2 y2 viewBox preserveAspectRatio pathLength'
).split(' ');

/** A drawing as the page has it: only geometry, no style, no script, nothing that loads; references are resolved. */
export interface BareDrawing {
  /** Laid out, but not seen; the drawing's own root is in it. */
  host: SVGSVGElement;
  root: SVGSVGElement;
  /** False where it is too large or too deep, and the rest was left out. */
  isWhole: boolean;
}

/** Copies a drawing into the page for as long as `use` takes. Undefined if the text is no SVG. */
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

/** In the order in which they are drawn. */
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
