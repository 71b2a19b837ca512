#pragma once

#include <vector>

#include "server/core/cut/curve.h"

namespace kerf::dxf {

struct Spline {
  int degree = 3;
  std::vector<double> knots;  // Ascending; as many as points + degree + 1.
  std::vector<Eigen::Vector2d> points;
  std::vector<double> weights;  // Empty: all 1.
};

inline constexpr int kMaxDegree = 16;

// Returns true if knots, points and weights fit together, and weights are above 0.
bool is_valid(const Spline& spline);

// Returns the spline as Bezier segments: exact up to degree 3, else cubic ones that follow it to a millionth of its
// size. The spline must be valid.
cut::Subpath segments_of(const Spline& spline);

// Returns the smooth cubic curve through the points, at least 2, with parameters by distance and no curvature at its
// ends.
cut::Subpath through_points(const std::vector<Eigen::Vector2d>& points);

}  // namespace kerf::dxf
