#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/cut/view_crossings.h"

namespace kerf::cut {

// View intervals joined end to end: one connected stretch of a cut on a picture.
struct ViewChain {
  std::vector<Eigen::Vector2d> points;  // m, material coordinates; closed if the last equals the first, bit for bit
  mesh::TriangleId first_triangle = mesh::kNone;
  ViewLayer layer;  // only length and depths are set
};

// Joins intervals at nodes that two of them share: on edges, also around folds, and at points of the curve. Chains are
// sorted by their lowest interval.
std::vector<ViewChain> link(const std::vector<ViewInterval>& intervals);

}  // namespace kerf::cut
