#pragma once

#include <optional>

#include <Eigen/Core>

namespace kerf::mesh {

// Distance from a plane that still counts as flat, over the size of the sheet.  -; single-precision files round by 1e-7
inline constexpr double kFlatness = 1e-6;

// Positions as coordinates of a plane, or the reason why they are not.
struct PlaneFit {
  std::optional<Eigen::Matrix2Xd> rest;  // 2 x V, m
  bool has_normal = false;               // false: the triangles' areas cancel, so they lie in no plane
  Eigen::Index farthest = 0;             // the vertex that is farthest out of the plane
  double height = 0.0;                   // m, its distance
  double allowed = 0.0;                  // m
};

// Puts vertices into the plane of the first one, across the sum of the triangles' area vectors. Coordinates are world x
// and y if this is nearly the x-y plane. Allows kFlatness of the size.
PlaneFit fit_plane(const Eigen::Matrix3Xd& world, const Eigen::Matrix3Xi& triangles);

// The same in the best plane of all vertices, for numbers that are rounded to multiples of `step` (m): each vertex may
// be as far out of it as such rounding brings it, but at most `most` (m).
PlaneFit fit_rounded_plane(const Eigen::Matrix3Xd& world, const Eigen::Matrix3Xi& triangles, double step, double most);

}  // namespace kerf::mesh
