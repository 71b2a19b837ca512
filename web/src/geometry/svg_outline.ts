import { shapesIn, withBareDrawing } from './bare_drawing';
import type { BareDrawing } from './bare_drawing';
import type { Point2 } from './locator';
import { countSegments, pathLines } from './path_lines';
import { shapeData } from './shape_data';

/**
 * The outlines of a drawing for a preview, in a box of their own: x and y (up) in 0..1. Its lines are within 1/5000 of the
 * drawing's larger side of its curves, unless it has more than some 300 of them.
 */
export interface SvgOutline {
  lines: readonly (readonly Point2[])[];
  /** Width over height of that box, > 0. */
  aspect: number;
}

// The largest distance of lines from their curves, in parts of the drawing's larger side.
const kTolerance = 2e-4;
// A curve has at most 64 chords, and fewer where there would be more points than this together.
const kMaxDepth = 6;
const kMaxSamples = 20_000;

/**
 * Reads a drawing by the browser's own SVG engine, which places the shapes. Undefined without a shape, if the text is no
 * SVG, or if it is too large to be read whole.
 */
export function svgOutline(text: string): SvgOutline | undefined {
  return withBareDrawing(text, (drawing) => (drawing.isWhole ? inUnitBox(shapeLines(drawing).flat()) : undefined));
}

/** The lines of each shape, in the pixels of the host; none where it shows nothing. */
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
    // Bounds the largest stretch.
    const scale = Math.hypot(toHost.a, toHost.b, toHost.c, toHost.d) || 1;
    const lines = pathLines(data[i], { tolerance: tolerance / scale, depth });
    return lines.map((line) => line.map(({ x, y }) => new DOMPoint(x, y).matrixTransform(toHost)));
  });
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
