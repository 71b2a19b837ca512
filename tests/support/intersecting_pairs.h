#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::test {

// Returns the corners of the solid triangles of a mesh.
std::vector<std::array<mesh::VertexId, 3>> solid_triangles(const mesh::TriangleMesh& mesh);

// Returns the number of pairs of triangles without a common vertex of which one has an edge that passes through the
// other. `positions` is 3 x V, m. Signs within rounding of 0 count as 0: triangles that touch, such as the lips of a
// new cut, and triangles of one plane do not intersect.
std::int64_t count_intersecting_pairs(std::span<const std::array<mesh::VertexId, 3>> triangles,
                                      const linear::VertexField& positions);

}  // namespace kerf::test
