// As server/service/codec/vertex_predictors.h: finds the earlier vertices from which a vertex is predicted.

export const kNoVertex = -1;

/** One entry per vertex in each array: an id below the vertex's own, or kNoVertex. */
export interface Predictors {
  nearA: Int32Array;
  nearB: Int32Array;
  across: Int32Array;
}

/** Returns the slots around each vertex, as lists that follow one another in an array. */
function slotsAround(triangles: Int32Array, numSlots: number, numVertices: number) {
  const begins = new Int32Array(numVertices + 1);
  for (let i = 0; i < 3 * numSlots; ++i) if (triangles[i] !== kNoVertex) ++begins[triangles[i] + 1];
  for (let v = 0; v < numVertices; ++v) begins[v + 1] += begins[v];
  const slots = new Int32Array(begins[numVertices]);
  const ends = begins.slice(0, numVertices);
  for (let i = 0; i < 3 * numSlots; ++i) {
    if (triangles[i] !== kNoVertex) slots[ends[triangles[i]]++] = (i / 3) | 0;
  }
  return { begins, slots };
}

/**
 * @param triangles  3 per slot: vertex ids in 0..numVertices-1, or three times kNoVertex
 */
export function vertexPredictors(triangles: Int32Array, numSlots: number, numVertices: number): Predictors {
  const nearA = new Int32Array(numVertices).fill(kNoVertex);
  const nearB = new Int32Array(numVertices).fill(kNoVertex);
  const across = new Int32Array(numVertices).fill(kNoVertex);
  // Becomes nearA of vertices that are the highest of no slot.
  const neighbours = new Int32Array(numVertices).fill(kNoVertex);
  for (let first = 0; first < 3 * numSlots; first += 3) {
    if (triangles[first] === kNoVertex) continue;
    const lowest = Math.min(triangles[first], triangles[first + 1], triangles[first + 2]);
    for (let k = 0; k < 3; ++k) {
      const vertex = triangles[first + k];
      const from = triangles[first + ((k + 1) % 3)];
      const to = triangles[first + ((k + 2) % 3)];
      if (nearA[vertex] === kNoVertex && from < vertex && to < vertex) {
        nearA[vertex] = from;
        nearB[vertex] = to;
      }
      if (neighbours[vertex] === kNoVertex && lowest < vertex) neighbours[vertex] = lowest;
    }
  }
  const { begins, slots } = slotsAround(triangles, numSlots, numVertices);
  for (let vertex = 0; vertex < numVertices; ++vertex) {
    const a = nearA[vertex];
    const b = nearB[vertex];
    if (a === kNoVertex) {
      nearA[vertex] = neighbours[vertex] === kNoVertex ? vertex - 1 : neighbours[vertex];
      continue;
    }
    for (let at = begins[a]; at < begins[a + 1]; ++at) {
      const first = 3 * slots[at];
      for (let k = 0; k < 3; ++k) {
        const from = triangles[first + ((k + 1) % 3)];
        const to = triangles[first + ((k + 2) % 3)];
        const corner = triangles[first + k];
        if (!((from === a && to === b) || (from === b && to === a)) || corner >= vertex) continue;
        if (across[vertex] === kNoVertex || corner < across[vertex]) across[vertex] = corner;
      }
    }
  }
  return { nearA, nearB, across };
}
