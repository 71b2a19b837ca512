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

/**
 * Finds the triangle that holds a material point, by a uniform grid over the sheet (about one triangle a cell). Built
 * once a topology; material positions do not change otherwise.
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

  /** The place of a material point, or undefined off the sheet. */
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

  private weights(slot: number, point: Point2): Place | undefined {
    const { material, triangles } = this;
    const [a, b, c] = [2 * triangles[3 * slot], 2 * triangles[3 * slot + 1], 2 * triangles[3 * slot + 2]];
    const [abX, abY] = [material[b] - material[a], material[b + 1] - material[a + 1]];
    const [acX, acY] = [material[c] - material[a], material[c + 1] - material[a + 1]];
    const [apX, apY] = [point.x - material[a], point.y - material[a + 1]];
    const area = abX * acY - abY * acX;
    if (area === 0) return undefined;
    const u = (apX * acY - apY * acX) / area;
    const v = (abX * apY - abY * apX) / area;
    // Room for the rounding of float32 positions, so that a point on an edge is not lost between its two triangles.
    const slack = -1e-5;
    return u >= slack && v >= slack && 1 - u - v >= slack ? { slot, u, v } : undefined;
  }

  private column(x: number): number {
    const width = this.max.x - this.min.x;
    return width > 0 ? Math.min(this.columns - 1, Math.floor(((x - this.min.x) / width) * this.columns)) : 0;
  }

  private row(y: number): number {
    const height = this.max.y - this.min.y;
    return height > 0 ? Math.min(this.rows - 1, Math.floor(((y - this.min.y) / height) * this.rows)) : 0;
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
