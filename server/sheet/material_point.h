#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "server/mesh/ids.h"
#include "server/mesh/triangle_mesh.h"

namespace kerf::sheet {

// A point of the sheet as a mean of the corners of one triangle.
struct MaterialPoint {
  std::array<mesh::VertexId, 3> vertices{mesh::kNone, mesh::kNone, mesh::kNone};
  Eigen::Vector3d weights{1.0, 0.0, 0.0};  // -, >= 0, sum 1
};

// Where `at` (m, material coordinates) lies; nothing where there is no material. On a lip both sides are there: the
// side of the lower slot is taken.
std::optional<MaterialPoint> find_material_point(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at);

}  // namespace kerf::sheet
