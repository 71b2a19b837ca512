#pragma once

#include <span>
#include <vector>

#include "server/core/cut/curve.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

// Returns the solid triangles of `mesh` that the strokes run through or have a point in, sorted, unique. Call it before
// the cut; reports compare the number of new triangles with them. A stroke exactly through a point or along an edge
// counts the triangles of one side.
std::vector<mesh::TriangleId> crossed_triangles(const mesh::TriangleMesh& mesh, std::span<const Stroke> strokes);

}  // namespace kerf::cut
