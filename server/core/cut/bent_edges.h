#pragma once

#include <array>
#include <span>
#include <vector>

#include "server/core/cut/curve.h"
#include "server/core/cut/cut.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

// Returns the bent edges of the triangles that the strokes run through, and of those around them. An edge is bent if
// its flip would move the sheet by more than the limit at its triangles. `positions`: 3 x V, m. Each edge is given by
// its ends. Lips, borders and edges of regions, which no flip removes, are left out.
std::vector<std::array<mesh::PointId, 2>> bent_edges(const mesh::TriangleMesh& mesh, std::span<const Stroke> strokes,
                                                     const linear::VertexField& positions, const ShiftLimit& limit);

}  // namespace kerf::cut
