#pragma once

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Returns sum_k weights[k] field(vertices[k]) for a field of 3 x V.
inline Eigen::Vector3d grab_point(const Grab& grab, const linear::VertexField& field) {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    if (grab.vertices[k] == mesh::kNone) continue;
    point += grab.weights[static_cast<Eigen::Index>(k)] * field.col(grab.vertices[k]);
  }
  return point;
}

}  // namespace kerf::fem
