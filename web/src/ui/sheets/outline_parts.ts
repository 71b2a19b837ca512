import { shapesIn, withBareDrawing } from '../../geometry/bare_drawing';
import type { BareDrawing } from '../../geometry/bare_drawing';
import { borderOf } from '../../geometry/nesting';
import { subpaths } from '../../geometry/path_lines';
import { shapeLines } from '../../geometry/svg_outline';

/** The border of a drawing and its holes, as two drawings on the same page. */
export interface OutlineParts {
  border: string;
  /** SVG text of all holes; undefined without holes. */
  holes: string | undefined;
  numHoles: number;
}

/**
 * Separates a drawing into border and holes. A drawing in which the browser finds at most one line stays as it is; the
 * server reports its faults.
 * @throws Error with a text for people, if lines are no holes in the largest one
 */
export function outlineParts(text: string): OutlineParts {
  return withBareDrawing(text, separated) ?? { border: text, holes: undefined, numHoles: 0 };
}

function separated(drawing: BareDrawing): OutlineParts | undefined {
  separateSubpaths(drawing.root);
  const lines = shapeLines(drawing).map(([line]) => line ?? []);
  // Leaves out subpaths of only a move and a close, which editors sometimes leave.
  const drawn = [...lines.keys()].filter((i) => lines[i].some(({ x, y }) => x !== lines[i][0].x || y !== lines[i][0].y));
  if (drawn.length < 2) return undefined;
  if (!drawing.isWhole) throw new Error('is too large to search for holes: remove everything that is not an outline');
  const border = drawn[borderOf(drawn.map((i) => lines[i]))];
  return {
    border: onlyShapes(drawing.root, [border]),
    holes: onlyShapes(drawing.root, drawn.filter((i) => i !== border)),
    numHoles: drawn.length - 1,
  };
}

// Splits paths, so that each shape is one line.
function separateSubpaths(root: Element): void {
  for (const shape of shapesIn(root)) {
    const parts = shape.localName === 'path' ? subpaths(shape.getAttribute('d') ?? '') : [];
    if (parts.length < 2) continue;
    const paths = parts.map((data) => {
      const path = shape.cloneNode() as Element;
      path.setAttribute('d', data);
      return path;
    });
    shape.replaceWith(...paths);
  }
}

function onlyShapes(root: Element, kept: readonly number[]): string {
  const copy = root.cloneNode(true) as Element;
  const isKept = new Set(kept);
  for (const [i, shape] of shapesIn(copy).entries()) if (!isKept.has(i)) shape.remove();
  return new XMLSerializer().serializeToString(copy);
}
