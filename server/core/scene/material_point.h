#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::sheet {

// A point of the sheet as a mean of the corners of one triangle.
struct MaterialPoint {
  std::array<mesh::VertexId, 3> vertices{mesh::kNone, mesh::kNone, mesh::kNone};
  Eigen::Vector3d weights{1.0, 0.0, 0.0};  // -, >= 0, sum 1

  // Interpolates a field (3 x V) at the point.
  template <typename Field>
  [[nodiscard]] Eigen::Vector3d of(const Field& field) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (vertices[k] != mesh::kNone) sum += weights[static_cast<Eigen::Index>(k)] * field.col(vertices[k]);
    }
    return sum;
  }
};

// Finds the triangle that holds `at` (m, material coordinates); nothing where there is no material. On a lip, which has
// two sides, the side of the lower slot is taken.
std::optional<MaterialPoint> find_material_point(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at);

// Finds the material point nearest to `at`, which a cut may have left in the void. A border edge that a cut splits is
// rounded to the lattice and may bow inwards by half a unit. So material that lay exactly on it is then outside. The
// lowest slot wins among equally near points.
MaterialPoint nearest_material_point(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at);

}  // namespace kerf::sheet
