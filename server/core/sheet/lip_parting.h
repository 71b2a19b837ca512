#pragma once

#include <span>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::sheet {

// Moves vertices that lie exactly on another copy of their point, as the lips of a new cut do, into their own material.
// They move by 3 % of `thickness` (m), or a tenth of the least altitude there if that is less. Lips that coincide have
// no direction in which contact of a sheet with itself could keep them apart. `triangles`: those with a corner at such
// a vertex. `held`: vertices to leave alone, sorted. `x`: positions, 3 x V, m.
void part_lips(const mesh::TriangleMesh& mesh, std::span<const mesh::TriangleId> triangles,
               std::span<const mesh::VertexId> held, double thickness, Eigen::Ref<Eigen::Matrix3Xd> x);

}  // namespace kerf::sheet
