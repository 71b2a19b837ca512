/**
 * Computes area-weighted vertex normals of the deformed sheet, of unit length; zero for a vertex without material.
 *
 * @param positions  3 V, metres
 * @param triangles  3 S vertex ids, -1 for empty slots
 * @param normals    receives 3 V numbers
 */
export function vertexNormals(
  positions: Float32Array,
  numVertices: number,
  triangles: Int32Array,
  numSlots: number,
  normals: Float32Array,
): void {
  const x = positions;
  normals.fill(0, 0, 3 * numVertices);
  for (let i = 0; i < 3 * numSlots; i += 3) {
    const a = 3 * triangles[i];
    if (a < 0) continue;
    const b = 3 * triangles[i + 1];
    const c = 3 * triangles[i + 2];
    const abX = x[b] - x[a],
      abY = x[b + 1] - x[a + 1],
      abZ = x[b + 2] - x[a + 2];
    const acX = x[c] - x[a],
      acY = x[c + 1] - x[a + 1],
      acZ = x[c + 2] - x[a + 2];
    const nX = abY * acZ - abZ * acY,
      nY = abZ * acX - abX * acZ,
      nZ = abX * acY - abY * acX;
    normals[a] += nX;
    normals[a + 1] += nY;
    normals[a + 2] += nZ;
    normals[b] += nX;
    normals[b + 1] += nY;
    normals[b + 2] += nZ;
    normals[c] += nX;
    normals[c + 1] += nY;
    normals[c + 2] += nZ;
  }
  for (let i = 0; i < 3 * numVertices; i += 3) {
    const length = Math.sqrt(normals[i] ** 2 + normals[i + 1] ** 2 + normals[i + 2] ** 2);
    if (length === 0) continue;
    normals[i] /= length;
    normals[i + 1] /= length;
    normals[i + 2] /= length;
  }
}
