#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "server/core/mesh/predicates.h"

// Distances in lattice units, in double precision, for choices that may be slightly off (what is near, what is
// ill-shaped). All decisions about topology use the exact predicates instead.
namespace kerf::mesh {

// Returns b - a, exactly.
inline Eigen::Vector2d difference(const LatticePoint& a, const LatticePoint& b) {
  return {static_cast<double>(b.x - a.x), static_cast<double>(b.y - a.y)};
}

// Returns the lattice point nearest to from + offset.
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
