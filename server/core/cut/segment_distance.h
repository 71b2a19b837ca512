#pragma once

#include <algorithm>

#include <Eigen/Core>

namespace kerf::cut {

// Returns the distance (m) of a point from the segment from a to b; a and b may be equal.
inline double distance_to_segment(const Eigen::Vector2d& point, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double squared = along.squaredNorm();
  const double t = squared > 0.0 ? std::clamp((point - a).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (point - a - t * along).norm();
}

}  // namespace kerf::cut
