import { shapesIn, withBareDrawing } from './bare_drawing';
import type { BareDrawing } from './bare_drawing';
import type { Point2 } from './locator';
import { countSegments, pathLines } from './path_lines';
import { shapeData } from './shape_data';

/**
 * The outlines of a drawing for a preview, in a box of their own: x and y (up) in 0..1. Lines differ from the curves by
 * at most 1/5000 of the drawing's larger side, unless it has more than some 300 curves.
 */
export interface SvgOutline {
  lines: readonly (readonly Point2[])[];
  /** Width over height of the drawing's box, > 0. */
  aspect: number;
}

// Largest distance of lines from their curves, as a share of the drawing's larger side.
const kTolerance = 2e-4;
// A curve has at most 2^kMaxDepth chords, and fewer if all curves together would have more than kMaxSamples points.
const kMaxDepth = 6;
const kMaxSamples = 20_000;

/**
 * Reads a drawing with the browser's own SVG engine, which places the shapes. Undefined if the text is no SVG, has no
 * shape, or is too large to be read whole.
 */
export function svgOutline(text: string): SvgOutline | undefined {
  return withBareDrawing(text, (drawing) => (drawing.isWhole ? inUnitBox(shapeLines(drawing).flat()) : undefined));
}

/** Returns the lines of each shape, in pixels of the host; none for a shape that shows nothing. */
export function shapeLines({ host, root }: BareDrawing): Point2[][][] {
  const fromScreen = host.getScreenCTM()?.inverse();
  const shapes = shapesIn(root);
  const data = shapes.map(shapeData);
  const segments = data.reduce((sum, text) => sum + countSegments(text), 0);
  const depth = Math.max(0, Math.min(kMaxDepth, Math.floor(Math.log2(kMaxSamples / Math.max(1, segments)))));
  const { width, height } = host.getBBox();
  const tolerance = kTolerance * Math.max(width, height);
  return shapes.map((shape, i) => {
    const matrix = shape.getScreenCTM();
    if (!fromScreen || !matrix) return [];
    const toHost = fromScreen.multiply(matrix);
    // An upper bound of the largest stretch.
    const scale = Math.hypot(toHost.a, toHost.b, toHost.c, toHost.d) || 1;
    const lines = pathLines(data[i], { tolerance: tolerance / scale, depth });
    return lines.map((line) => line.map(({ x, y }) => new DOMPoint(x, y).matrixTransform(toHost)));
  });
}

/** Scales lines into the unit box. Undefined without points, or if all points are equal. */
export function inUnitBox(lines: readonly (readonly Point2[])[]): SvgOutline | undefined {
  let [minX, minY, maxX, maxY] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const { x, y } of lines.flat()) {
    [minX, maxX] = [Math.min(minX, x), Math.max(maxX, x)];
    [minY, maxY] = [Math.min(minY, y), Math.max(maxY, y)];
  }
  const larger = Math.max(maxX - minX, maxY - minY);
  if (!(larger > 0)) return undefined;
  // A straight line gets a thin box.
  const [width, height] = [Math.max(maxX - minX, 1e-3 * larger), Math.max(maxY - minY, 1e-3 * larger)];
  return {
    lines: lines.map((line) => line.map(({ x, y }) => ({ x: (x - minX) / width, y: (maxY - y) / height }))),
    aspect: width / height,
  };
}
