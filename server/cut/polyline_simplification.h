#pragma once

#include <vector>

#include <Eigen/Core>

namespace kerf::cut {

// Leaves points of a polyline out where it then stays within `tolerance` (m) of what it was (Douglas and Peucker 1973,
// "Algorithms for the reduction of the number of points required to represent a digitized line or its caricature").
// Ends stay, and a closed polyline (last point equals first) stays closed. Replaces the contents of `kept`; returns the
// largest distance of a point left out from the segment that stands for it, m.
double simplify(const std::vector<Eigen::Vector2d>& points, double tolerance, std::vector<Eigen::Vector2d>& kept);

}  // namespace kerf::cut
