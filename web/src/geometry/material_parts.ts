import type { MaterialLine, Region } from '../gen/kerf/v1/conditions_pb';
import { MaterialLine_Side } from '../gen/kerf/v1/conditions_pb';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { SheetArrays } from '../stream/sheet_copy';
import { curveLines } from './curve_lines';
import { Locator } from './locator';
import type { Point2 } from './locator';
import { chordsOf, SegmentGrid } from './segment_grid';

/** True of places on the undeformed sheet that belong to a part, metres. */
type Holds = (at: Point2) => boolean;

// Distance of chords from their curve, as a share of the part's reach.
const kFlatness = 0.01;

const kOrigin: Point2 = { x: 0, y: 0 };

function nowhere(): boolean {
  return false;
}

function isWanted(side: MaterialLine_Side, left: number): boolean {
  return (side === MaterialLine_Side.LEFT_OF_LINE) === left > 0;
}

/** Returns by how much a place is on the left of the chords, at the nearest one; only the sign matters. */
function offsetFrom(chords: Float64Array, { x, y }: Point2): number {
  let [least, left] = [Infinity, 0];
  for (let i = 0; i < chords.length; i += 4) {
    const [ax, ay, dx, dy] = [chords[i], chords[i + 1], chords[i + 2] - chords[i], chords[i + 3] - chords[i + 1]];
    const length = Math.hypot(dx, dy);
    if (length === 0) continue;
    const t = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (length * length)));
    const distance = Math.hypot(x - ax - t * dx, y - ay - t * dy);
    // Two chords that meet are equally near beside their joint. The one that the place is farther off decides.
    const offset = (dx * (y - ay) - dy * (x - ax)) / length;
    const isTie = Math.abs(distance - least) <= 1e-9 * distance;
    if (isTie ? Math.abs(offset) > Math.abs(left) : distance < least) [least, left] = [distance, offset];
  }
  return left;
}

// Without a reach of its own, a line or a curve is too thin here; the server's reach is a twentieth of an edge then.
function along(lines: readonly Point2[][], { withinM, side }: Pick<MaterialLine, 'withinM' | 'side'>): Holds {
  if (withinM <= 0) return nowhere;
  const chords = chordsOf(lines);
  const grid = new SegmentGrid(chords, withinM);
  const isBoth = side !== MaterialLine_Side.LEFT_OF_LINE && side !== MaterialLine_Side.RIGHT_OF_LINE;
  return (at) => grid.has(at.x, at.y) && (isBoth || isWanted(side, offsetFrom(chords, at)));
}

// The triangles that have all corners in the list, in a copy that later cuts do not change.
function listed(vertices: ReadonlySet<number>, { triangles, numSlots, numVertices, materialPositions }: SheetArrays): Holds {
  const own: number[] = [];
  for (let i = 0; i < 3 * numSlots; i += 3) {
    const corners = triangles.subarray(i, i + 3);
    if (corners.every((corner) => vertices.has(corner))) own.push(...corners);
  }
  const locator = new Locator(materialPositions.slice(0, 2 * numVertices), numVertices, Int32Array.from(own), own.length / 3);
  return (at) => locator.find(at) !== undefined;
}

/**
 * Finds the material of each triangle from Scene.materials, as frames do not say it. A triangle belongs to a part if its
 * centroid does. Drawings that are still a file, and borders that do not follow the mesh, are not known exactly. Nor are
 * lists of vertices on a sheet that was cut before.
 */
export class MaterialParts {
  private holds: readonly Holds[] | undefined;

  constructor(private readonly sheet: Pick<Sheet, 'scene' | 'components'>) {}

  /** Returns for each slot 0 for Scene.material, or i + 1 for Scene.materials[i]. */
  ofTriangles(sheet: SheetArrays): Uint8Array {
    const { triangles, numSlots, materialPositions: m } = sheet;
    this.holds ??= (this.sheet.scene?.materials ?? []).map(({ region }) => (region ? this.part(region, sheet) : nowhere));
    const parts = new Uint8Array(numSlots);
    for (let slot = 0; slot < numSlots; ++slot) {
      const [a, b, c] = triangles.subarray(3 * slot, 3 * slot + 3);
      if (a < 0) continue;
      const at = { x: (m[2 * a] + m[2 * b] + m[2 * c]) / 3, y: (m[2 * a + 1] + m[2 * b + 1] + m[2 * c + 1]) / 3 };
      // A later part is laid over those before.
      let part = this.holds.length;
      while (part > 0 && !this.holds[part - 1](at)) part -= 1;
      parts[slot] = part;
    }
    return parts;
  }

  private part({ region, component }: Region, sheet: SheetArrays): Holds {
    const within = this.sheet.components.find(({ name }) => name === component);
    const { x: ox, y: oy } = within?.offset ?? kOrigin;
    const { min, max } = within?.extent ?? {};
    const isWithin = (at: Point2) => !min || !max || (at.x >= min.x && at.x <= max.x && at.y >= min.y && at.y <= max.y);
    const holds = this.shape(region, sheet, within?.firstVertex ?? 0);
    return (at) => {
      const own = { x: at.x - ox, y: at.y - oy };
      return isWithin(own) && holds(own, at);
    };
  }

  // Returns a function of a place in coordinates of the component, and in those of the sheet.
  private shape(region: Region['region'], sheet: SheetArrays, firstVertex: number): (own: Point2, at: Point2) => boolean {
    switch (region.case) {
      case 'all':
        return () => true;
      case 'box': {
        const { min = kOrigin, max = kOrigin } = region.value;
        return ({ x, y }) => x >= min.x && x <= max.x && y >= min.y && y <= max.y;
      }
      case 'line': {
        const { a = kOrigin, b = kOrigin } = region.value;
        return along([[a, b]], region.value);
      }
      case 'curve': {
        const { curve, withinM } = region.value;
        return along(curve ? curveLines(curve, kFlatness * withinM) : [], region.value);
      }
      case 'vertices': {
        const holds = listed(new Set(region.value.vertices.map((vertex) => vertex + firstVertex)), sheet);
        return (_, at) => holds(at);
      }
      default:
        return nowhere;
    }
  }
}
