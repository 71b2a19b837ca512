#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/cut/view_crossings.h"

namespace kerf::cut {

// Intervals joined end to end.
struct ViewChain {
  std::vector<Eigen::Vector2d> points;  // m, rest space; closed where the last equals the first, bit for bit
  mesh::TriangleId first_triangle = mesh::kNone;
  ViewLayer layer;  // its lengths and depths
};

// Joins intervals at the nodes that two of them share: across edges, around folds, and at the points of the curve.
// Chains are in the order of their first intervals.
std::vector<ViewChain> link(const std::vector<ViewInterval>& intervals);

}  // namespace kerf::cut
