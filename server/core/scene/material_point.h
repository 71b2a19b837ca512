#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::scene {

// A point of the sheet as a weighted mean of the corners of one triangle.
struct MaterialPoint {
  std::array<mesh::VertexId, 3> vertices{mesh::kNone, mesh::kNone, mesh::kNone};
  Eigen::Vector3d weights{1.0, 0.0, 0.0};  // -, >= 0, sum 1

  // Interpolates a field (3 x V) at this point.
  template <typename Field>
  [[nodiscard]] Eigen::Vector3d of(const Field& field) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (vertices[k] != mesh::kNone) sum += weights[static_cast<Eigen::Index>(k)] * field.col(vertices[k]);
    }
    return sum;
  }
};

// Finds the point of the sheet at `at` (m, material coordinates). Returns nothing if there is no material. On a lip,
// where two triangles have the point, it is in the one with the lower slot.
std::optional<MaterialPoint> find_material_point(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at);

// Finds the point of the sheet nearest to `at` (m, material coordinates), which may be in the void. Even a point on the
// border can end up there: when a cut splits a border edge, rounding may move the split inwards by half a lattice unit.
// Among equally near points that in the lowest slot wins.
MaterialPoint nearest_material_point(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at);

}  // namespace kerf::scene
