#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/material_point.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::scene {

// A mesh and the start positions of its vertices in the world.
struct BuiltMesh {
  mesh::TriangleMesh mesh;
  Eigen::Matrix3Xd positions;  // 3 x V, m

  // Returns the point of the mesh at, or nearest to, `material` (m, material coordinates).
  [[nodiscard]] MaterialPoint at(const Eigen::Vector2d& material) const;
  // Returns the gradient (-) of the start position by material coordinates, in the triangle that holds the point.
  [[nodiscard]] Eigen::Matrix<double, 3, 2> gradient_at(const MaterialPoint& point) const;
};

// Builds the mesh of a valid source. Errors: those of the mesh importers and of outline_source.h, with the field as in
// kerf.v1.Scene. An outline with more than `max_vertices` vertices is refused; for other sources the caller checks
// their number.
Result<BuiltMesh> build_mesh(const MeshSource& source, const Placement& placement, std::int32_t max_vertices);

}  // namespace kerf::scene
