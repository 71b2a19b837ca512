#pragma once

#include <Eigen/Core>

#include "server/base/elementary.h"
#include "server/core/linear/cross_matrix.h"

namespace kerf::linear {

// Returns the rotation by `angle` (rad) about the unit vector `axis`, by the formula of Rodrigues. Eigen::AngleAxisd
// takes sine and cosine from the C library, see elementary.h.
inline Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, double angle) {
  const double c = cosine(angle);
  const Eigen::Vector3d weighted = (1.0 - c) * axis;
  return weighted * axis.transpose() + cross_matrix(sine(angle) * axis) + c * Eigen::Matrix3d::Identity();
}

}  // namespace kerf::linear
