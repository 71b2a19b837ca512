import { shapesIn, withBareDrawing } from './bare_drawing';
import type { BareDrawing } from './bare_drawing';
import type { Point2 } from './locator';
import { countSegments, pathLines } from './path_lines';

/** The outlines of a drawing for a preview, in a box of their own: x and y (up) in 0..1. */
export interface SvgOutline {
  lines: readonly (readonly Point2[])[];
  /** Width over height of that box, > 0. */
  aspect: number;
}

// Beyond these a preview is coarser.
const kMaxSamples = 20_000;
const kMaxPieces = 16;
// Chords of what has no corners but its own.
const kShapeSamples = 192;

/**
 * What the browser makes of a drawing: its own SVG engine places and measures the shapes. Undefined without a shape, or
 * if the text is no SVG.
 */
export function svgOutline(text: string): SvgOutline | undefined {
  return withBareDrawing(text, (drawing) => inUnitBox(shapeLines(drawing).flat()));
}

/** The lines of each shape, in the pixels of the host; none where it shows nothing. */
export function shapeLines({ host, root }: BareDrawing): Point2[][][] {
  const fromScreen = host.getScreenCTM()?.inverse();
  const shapes = shapesIn(root);
  const data = shapes.map((shape) => shape.getAttribute('d') ?? '');
  const segments = data.reduce((sum, text) => sum + countSegments(text), 0);
  const pieces = Math.min(kMaxPieces, Math.max(1, Math.floor(kMaxSamples / Math.max(1, segments))));
  const arc = document.createElementNS(host.namespaceURI, 'path') as SVGPathElement;
  host.append(arc);
  const arcPoints = (of: string, count: number) => {
    arc.setAttribute('d', of);
    return equidistant(arc, count);
  };
  return shapes.map((shape, i) => {
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
