/**
 * Returns the edges with material on one side only: the outer border, holes and the lips of cuts.
 *
 * @param triangles    3 S vertex ids, consistently oriented; -1 for empty slots
 * @param numSlots     S
 * @param numVertices  V
 * @returns 3 n numbers: start, end, slot of each edge, with the triangle on its left
 */
export function boundaryEdges(triangles: Int32Array, numSlots: number, numVertices: number): Uint32Array {
  // Half-edges are sorted by their smaller vertex (counting sort); each is then compared with the few that have the
  // same smaller vertex.
  const first = new Uint32Array(numVertices + 2);
  forEachHalfEdge(triangles, numSlots, (a, b) => ++first[Math.min(a, b) + 2]);
  for (let v = 2; v < first.length; ++v) first[v] += first[v - 1];
  const numHalfEdges = first[numVertices + 1];
  const start = new Uint32Array(numHalfEdges);
  const end = new Uint32Array(numHalfEdges);
  const slots = new Uint32Array(numHalfEdges);
  forEachHalfEdge(triangles, numSlots, (a, b, slot) => {
    const at = first[Math.min(a, b) + 1]++;
    start[at] = a;
    end[at] = b;
    slots[at] = slot;
  });

  const edges: number[] = [];
  for (let v = 0; v < numVertices; ++v) {
    for (let i = first[v]; i < first[v + 1]; ++i) {
      let isPaired = false;
      for (let j = first[v]; j < first[v + 1] && !isPaired; ++j) isPaired = start[j] === end[i] && end[j] === start[i];
      if (!isPaired) edges.push(start[i], end[i], slots[i]);
    }
  }
  return Uint32Array.from(edges);
}

function forEachHalfEdge(
  triangles: Int32Array,
  numSlots: number,
  visit: (a: number, b: number, slot: number) => void,
): void {
  for (let slot = 0; slot < numSlots; ++slot) {
    const [a, b, c] = [triangles[3 * slot], triangles[3 * slot + 1], triangles[3 * slot + 2]];
    if (a < 0) continue;
    visit(a, b, slot);
    visit(b, c, slot);
    visit(c, a, slot);
  }
}
