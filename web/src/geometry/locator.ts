/** A place on the sheet: the triangle slot and the weights of its second and third corner. */
export interface Place {
  slot: number;
  u: number;
  v: number;
}

export interface Point2 {
  x: number;
  y: number;
}

/** The part of a chord that lies in a triangle; `start` and `end` go from 0 at the chord's start to 1 at its end. */
export interface Crossing {
  slot: number;
  start: number;
  end: number;
}

// A shorter part of a chord is a rounding error.
const kLeastPart = 1e-9;
// A corner's weight may be this far below 0, so that a chord along an edge lies in the triangles on both sides despite
// rounding.
const kOnEdge = 1e-9;

/**
 * Finds the triangle that contains a material point, by a uniform grid over the sheet with about one triangle per cell.
 * One is built for each topology version, because material positions do not change within one.
 */
export class Locator {
  readonly min: Point2;
  readonly max: Point2;
  private readonly columns: number;
  private readonly rows: number;
  // Slots of cell c: cellSlots[cellFirst[c]] .. cellSlots[cellFirst[c + 1] - 1].
  private readonly cellFirst: Uint32Array;
  private readonly cellSlots: Uint32Array;

  /**
   * @param material   2 V, metres
   * @param triangles  3 S vertex ids, -1 for empty slots
   */
  constructor(
    private readonly material: Float32Array,
    numVertices: number,
    private readonly triangles: Int32Array,
    numSlots: number,
  ) {
    this.min = { x: Infinity, y: Infinity };
    this.max = { x: -Infinity, y: -Infinity };
    for (let v = 0; v < numVertices; ++v) {
      this.min.x = Math.min(this.min.x, material[2 * v]);
      this.min.y = Math.min(this.min.y, material[2 * v + 1]);
      this.max.x = Math.max(this.max.x, material[2 * v]);
      this.max.y = Math.max(this.max.y, material[2 * v + 1]);
    }
    const side = Math.max(1, Math.min(512, Math.floor(Math.sqrt(numSlots))));
    this.columns = side;
    this.rows = side;
    this.cellFirst = new Uint32Array(side * side + 2);
    this.forEachCell(numSlots, (cell) => ++this.cellFirst[cell + 2]);
    for (let c = 2; c < this.cellFirst.length; ++c) this.cellFirst[c] += this.cellFirst[c - 1];
    this.cellSlots = new Uint32Array(this.cellFirst[side * side + 1]);
    this.forEachCell(numSlots, (cell, slot) => (this.cellSlots[this.cellFirst[cell + 1]++] = slot));
  }

  /** Returns the place of a material point; undefined off the sheet. */
  find(point: Point2): Place | undefined {
    const { min, max } = this;
    if (!(point.x >= min.x && point.x <= max.x && point.y >= min.y && point.y <= max.y)) return undefined;
    const cell = this.row(point.y) * this.columns + this.column(point.x);
    for (let i = this.cellFirst[cell]; i < this.cellFirst[cell + 1]; ++i) {
      const place = this.weights(this.cellSlots[i], point);
      if (place) return place;
    }
    return undefined;
  }

  /**
   * Returns the triangles that a chord passes through, in order along it. Parts do not overlap; those off the sheet are
   * missing.
   */
  along(from: Point2, to: Point2): Crossing[] {
    const found: Crossing[] = [];
    this.forEachCellOn(from, to, (cell) => {
      for (let i = this.cellFirst[cell]; i < this.cellFirst[cell + 1]; ++i) {
        const crossing = this.crossing(this.cellSlots[i], from, to);
        if (crossing) found.push(crossing);
      }
    });
    found.sort((one, other) => one.start - other.start || one.slot - other.slot);
    const crossings: Crossing[] = [];
    let done = 0;
    for (const { slot, start, end } of found) {
      const first = Math.max(start, done);
      if (end - first <= kLeastPart) continue;
      crossings.push({ slot, start: first, end });
      done = end;
    }
    return crossings;
  }

  /** Returns slots of triangles around a polygon, each once: all that the polygon overlaps, and some beside it. */
  slotsAround(polygon: readonly Point2[]): Set<number> {
    const [xs, ys] = [polygon.map(({ x }) => x), polygon.map(({ y }) => y)];
    const [first, last] = [this.column(Math.min(...xs)), this.column(Math.max(...xs))];
    const top = this.row(Math.max(...ys));
    const slots = new Set<number>();
    for (let row = this.row(Math.min(...ys)); row <= top; ++row) {
      const cell = row * this.columns;
      for (let i = this.cellFirst[cell + first]; i < this.cellFirst[cell + last + 1]; ++i) slots.add(this.cellSlots[i]);
    }
    return slots;
  }

  /** Returns the material positions of a triangle's corners. */
  cornersOf(slot: number): Point2[] {
    return [0, 1, 2].map((corner) => {
      const at = 2 * this.triangles[3 * slot + corner];
      return { x: this.material[at], y: this.material[at + 1] };
    });
  }

  /**
   * Expresses a point, which may be outside, by the weights of a triangle's second and third corner. Undefined if the
   * triangle has no area.
   */
  placeIn(slot: number, point: Point2): Place | undefined {
    const { material, triangles } = this;
    const [a, b, c] = [2 * triangles[3 * slot], 2 * triangles[3 * slot + 1], 2 * triangles[3 * slot + 2]];
    const [abX, abY] = [material[b] - material[a], material[b + 1] - material[a + 1]];
    const [acX, acY] = [material[c] - material[a], material[c + 1] - material[a + 1]];
    const [apX, apY] = [point.x - material[a], point.y - material[a + 1]];
    const area = abX * acY - abY * acX;
    if (area === 0) return undefined;
    return { slot, u: (apX * acY - apY * acX) / area, v: (abX * apY - abY * apX) / area };
  }

  private weights(slot: number, point: Point2): Place | undefined {
    const place = this.placeIn(slot, point);
    // Allows for the rounding of float32 positions, so that a point on an edge is found in one of its two triangles.
    const slack = -1e-5;
    return place && place.u >= slack && place.v >= slack && 1 - place.u - place.v >= slack ? place : undefined;
  }

  // Returns the part of a chord where no corner's weight is below 0. Makes no objects for the many triangles that the
  // chord misses.
  private crossing(slot: number, from: Point2, to: Point2): Crossing | undefined {
    const { material: m, triangles } = this;
    const [a, b, c] = [2 * triangles[3 * slot], 2 * triangles[3 * slot + 1], 2 * triangles[3 * slot + 2]];
    const [abX, abY] = [m[b] - m[a], m[b + 1] - m[a + 1]];
    const [acX, acY] = [m[c] - m[a], m[c + 1] - m[a + 1]];
    const area = abX * acY - abY * acX;
    if (area === 0) return undefined;
    const [fromX, fromY] = [from.x - m[a], from.y - m[a + 1]];
    const [toX, toY] = [to.x - m[a], to.y - m[a + 1]];
    const [u0, u1] = [(fromX * acY - fromY * acX) / area, (toX * acY - toY * acX) / area];
    const [v0, v1] = [(abX * fromY - abY * fromX) / area, (abX * toY - abY * toX) / area];
    let [start, end] = [0, 1];
    for (let corner = 0; corner < 3; ++corner) {
      const first = (corner === 0 ? u0 : corner === 1 ? v0 : 1 - u0 - v0) + kOnEdge;
      const last = (corner === 0 ? u1 : corner === 1 ? v1 : 1 - u1 - v1) + kOnEdge;
      if (first < 0 && last < 0) return undefined;
      if (first < 0) start = Math.max(start, first / (first - last));
      else if (last < 0) end = Math.min(end, first / (first - last));
    }
    return end > start ? { slot, start, end } : undefined;
  }

  private column(x: number): number {
    return cellOf(x, this.min.x, this.max.x, this.columns);
  }

  private row(y: number): number {
    return cellOf(y, this.min.y, this.max.y, this.rows);
  }

  // Visits in each row the cells between the columns in which the chord enters and leaves the row.
  private forEachCellOn(from: Point2, to: Point2, visit: (cell: number) => void): void {
    const { min, max, rows, columns } = this;
    const [low, high] = from.y < to.y ? [from, to] : [to, from];
    const height = (max.y - min.y) / rows;
    for (let row = this.row(low.y); row <= this.row(high.y); ++row) {
      const xAt = (y: number) => {
        const t = Math.min(1, Math.max(0, (y - low.y) / (high.y - low.y)));
        return low.x + t * (high.x - low.x);
      };
      // Widened a little for rounding. In the first and last row the chord's end is used, because it may lie outside
      // the grid.
      const room = 1e-6 * height;
      const bottom = row === this.row(low.y) ? low.x : xAt(min.y + row * height - room);
      const top = row === this.row(high.y) ? high.x : xAt(min.y + (row + 1) * height + room);
      const last = this.column(Math.max(bottom, top) + room);
      for (let column = this.column(Math.min(bottom, top) - room); column <= last; ++column) visit(row * columns + column);
    }
  }

  private forEachCell(numSlots: number, visit: (cell: number, slot: number) => void): void {
    const { material, triangles } = this;
    for (let slot = 0; slot < numSlots; ++slot) {
      const [a, b, c] = [2 * triangles[3 * slot], 2 * triangles[3 * slot + 1], 2 * triangles[3 * slot + 2]];
      if (a < 0) continue;
      const firstColumn = this.column(Math.min(material[a], material[b], material[c]));
      const lastColumn = this.column(Math.max(material[a], material[b], material[c]));
      const firstRow = this.row(Math.min(material[a + 1], material[b + 1], material[c + 1]));
      const lastRow = this.row(Math.max(material[a + 1], material[b + 1], material[c + 1]));
      for (let row = firstRow; row <= lastRow; ++row) {
        for (let column = firstColumn; column <= lastColumn; ++column) visit(row * this.columns + column, slot);
      }
    }
  }
}

// Returns the cell of a coordinate; one outside belongs to the first or the last cell.
function cellOf(at: number, min: number, max: number, count: number): number {
  const size = max - min;
  return size > 0 ? Math.min(count - 1, Math.max(0, Math.floor(((at - min) / size) * count))) : 0;
}
