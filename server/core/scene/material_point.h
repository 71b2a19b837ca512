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

  // Of a field of 3 x V.
  template <typename Field>
  [[nodiscard]] Eigen::Vector3d of(const Field& field) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (vertices[k] != mesh::kNone) sum += weights[static_cast<Eigen::Index>(k)] * field.col(vertices[k]);
    }
    return sum;
  }
};

// Where `at` (m, material coordinates) lies; nothing where there is no material. On a lip both sides are there: the
// side of the lower slot is taken.
std::optional<MaterialPoint> find_material_point(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at);

// Where `at` is held when a cut has left it in the void: a border edge that a cut splits is rounded to the lattice and
// may bow inwards by half a unit, so material that lay exactly on it is then outside. Of equally near points, that of
// the lowest slot.
MaterialPoint nearest_material_point(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at);

}  // namespace kerf::sheet
