#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::analysis {

// A point of a lip: on edge k of triangle t, from vertex a to b with the material on its left.
struct LipPoint {
  mesh::VertexId a = mesh::kNone;
  mesh::VertexId b = mesh::kNone;
  mesh::VertexId opposite = mesh::kNone;
  double share = 0.0;  // -, 0..1: of b

  [[nodiscard]] Eigen::Vector3d at(const mesh::VertexField& x) const {
    return (1.0 - share) * x.col(a) + share * x.col(b);
  }
};

// The two lips of a cut at a material point: [0] on the left of the direction in which the cut goes right (of a
// vertical one: up), [1] on its right.
using LipPair = std::array<LipPoint, 2>;

// Finds the two lips nearest to `at` (m, material). Nothing if one of the two is farther away than a thousandth of the
// sheet's size.
std::optional<LipPair> find_lips(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at);

// Returns the displacement (m) of lip [0] from lip [1]: along the normal and the tangent of the cut, and along the
// normal of the sheet. The frame is the mean of those of both lips at positions x (3 x V, m).
Eigen::Vector3d opening(const LipPair& lips, const mesh::VertexField& x);

}  // namespace kerf::analysis
