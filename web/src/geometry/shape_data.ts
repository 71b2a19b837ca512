import type { Point2 } from './locator';

/** Returns path data of a rectangle with corners rounded by rx, ry (SVG 1.1, 9.2); empty if it has no area. */
export function rectangleData(x: number, y: number, width: number, height: number, rx: number, ry: number): string {
  if (!(width > 0 && height > 0)) return '';
  const [a, b] = [Math.min(rx, 0.5 * width), Math.min(ry, 0.5 * height)];
  if (!(a > 0 && b > 0)) return `M${x} ${y}h${width}v${height}h${-width}z`;
  const corner = (dx: number, dy: number) => `a${a} ${b} 0 0 1 ${dx} ${dy}`;
  const [sideX, sideY] = [width - 2 * a, height - 2 * b];
  return (
    `M${x + a} ${y}h${sideX}${corner(a, b)}v${sideY}${corner(-a, b)}` +
    `h${-sideX}${corner(-a, -b)}v${-sideY}${corner(a, -b)}z`
  );
}

/** Returns path data of an ellipse around (cx, cy); empty if it has no area. */
export function ellipseData(cx: number, cy: number, rx: number, ry: number): string {
  if (!(rx > 0 && ry > 0)) return '';
  return `M${cx + rx} ${cy}a${rx} ${ry} 0 0 1 ${-2 * rx} 0a${rx} ${ry} 0 0 1 ${2 * rx} 0z`;
}

/** Returns path data of straight lines through points; empty for fewer than two points. */
export function linesData(points: readonly Point2[], isClosed: boolean): string {
  if (points.length < 2) return '';
  return `M${points.map(({ x, y }) => `${x} ${y}`).join('L')}${isClosed ? 'z' : ''}`;
}

function pointsOf({ points }: SVGPolygonElement | SVGPolylineElement): Point2[] {
  return Array.from({ length: points.numberOfItems }, (_, i) => points.getItem(i));
}

/** Returns path data of any basic shape, in the shape's own coordinates; empty if it draws nothing. */
export function shapeData(shape: SVGGeometryElement): string {
  const lengths = (names: string): number[] =>
    names.split(' ').map((name) => (shape as unknown as Record<string, SVGAnimatedLength>)[name].baseVal.value);
  switch (shape.localName) {
    case 'rect': {
      const [x, y, width, height, rx, ry] = lengths('x y width height rx ry');
      // A missing radius equals the other one.
      const has = (name: string) => shape.hasAttribute(name);
      return rectangleData(x, y, width, height, has('rx') ? rx : ry, has('ry') ? ry : rx);
    }
    case 'circle': {
      const [cx, cy, r] = lengths('cx cy r');
      return ellipseData(cx, cy, r, r);
    }
    case 'ellipse': {
      const [cx, cy, rx, ry] = lengths('cx cy rx ry');
      return ellipseData(cx, cy, rx, ry);
    }
    case 'line': {
      const [x1, y1, x2, y2] = lengths('x1 y1 x2 y2');
      return linesData([{ x: x1, y: y1 }, { x: x2, y: y2 }], false);
    }
    case 'polyline':
      return linesData(pointsOf(shape as SVGPolylineElement), false);
    case 'polygon':
      return linesData(pointsOf(shape as SVGPolygonElement), true);
    default:
      return shape.getAttribute('d') ?? '';
  }
}
