#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::analysis {

// A point of a lip. It lies on the edge of a triangle from vertex a to vertex b, with the material on its left.
struct LipPoint {
  mesh::VertexId a = mesh::kNone;
  mesh::VertexId b = mesh::kNone;
  mesh::VertexId opposite = mesh::kNone;
  double share = 0.0;  // -, 0..1, weight of b in the position; that of a is 1 - share

  [[nodiscard]] Eigen::Vector3d at(const linear::VertexField& x) const {
    return (1.0 - share) * x.col(a) + share * x.col(b);
  }
};

// The two lips of a cut at a material point. The cut is taken to run to the right in material coordinates, or up if it
// is vertical. Lip [0] bounds the material on its left, lip [1] that on its right.
using LipPair = std::array<LipPoint, 2>;

// Finds the two lips nearest to `at` (m, material coordinates). Returns nothing if one of them is farther away than a
// thousandth of the sheet's larger side.
std::optional<LipPair> find_lips(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at);

// Returns the displacement (m) of lip [0] relative to lip [1]: along the normal of the cut, along its tangent, and
// along the normal of the sheet. These directions are means for both lips at positions x (3 x V, m).
Eigen::Vector3d opening(const LipPair& lips, const linear::VertexField& x);

}  // namespace kerf::analysis
