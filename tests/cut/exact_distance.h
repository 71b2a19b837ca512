#pragma once

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/core/cut/curve.h"

// Checks flattened curves by distances in long double.
namespace kerf::cut {

using Real = long double;
using Point = Eigen::Matrix<Real, 2, 1>;

inline Real distance_to_segment(const Point& point, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Point along = (b - a).cast<Real>();
  const Real t = std::clamp((point - a.cast<Real>()).dot(along) / along.squaredNorm(), 0.0L, 1.0L);
  return (point - a.cast<Real>() - t * along).norm();
}

inline Real distance_to_stroke(const Point& point, const Stroke& stroke) {
  Real best = std::numeric_limits<Real>::infinity();
  for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
    best = std::min(best, distance_to_segment(point, stroke.points[i], stroke.points[i + 1]));
  }
  return best;
}

inline Path path_of(const Eigen::Vector2d& start, std::vector<Segment> segments, bool closed = false) {
  return {{{start, std::move(segments), closed}}};
}

}  // namespace kerf::cut
