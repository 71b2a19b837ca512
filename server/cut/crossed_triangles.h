#pragma once

#include <cstdint>
#include <span>

#include "server/cut/curve.h"
#include "server/mesh/triangle_mesh.h"

namespace kerf::cut {

// Number of different solid triangles of the mesh as it is that the strokes run through or have a point in: the
// yardstick that the number of new triangles is measured by. A stroke that passes exactly through a point or along an
// edge counts the triangles of one side.
std::int32_t count_crossed_triangles(const mesh::TriangleMesh& mesh, std::span<const Stroke> strokes);

}  // namespace kerf::cut
