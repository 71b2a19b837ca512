#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "server/core/mesh/predicates.h"

// Measures in lattice units, in double: for choices that may be a little off (what is near, what is ill-shaped). What
// decides topology goes through the exact predicates.
namespace kerf::mesh {

// b - a, exact.
inline Eigen::Vector2d difference(const LatticePoint& a, const LatticePoint& b) {
  return {static_cast<double>(b.x - a.x), static_cast<double>(b.y - a.y)};
}

// The lattice point nearest to from + offset.
inline LatticePoint rounded(const LatticePoint& from, const Eigen::Vector2d& offset) {
  return {from.x + std::llround(offset.x()), from.y + std::llround(offset.y())};
}

inline double squared_distance(const LatticePoint& a, const LatticePoint& b) {
  return difference(a, b).squaredNorm();
}

inline double distance_to_segment(const LatticePoint& p, const LatticePoint& a, const LatticePoint& b) {
  const Eigen::Vector2d along = difference(a, b);
  const Eigen::Vector2d offset = difference(a, p);
  const double squared_length = along.squaredNorm();
  if (squared_length == 0.0) return offset.norm();
  const double t = std::clamp(offset.dot(along) / squared_length, 0.0, 1.0);
  return (offset - t * along).norm();
}

}  // namespace kerf::mesh
