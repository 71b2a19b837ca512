#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/cut/curve.h"

namespace kerf::audit {

// Returns a polyline of `samples` + 1 points for each piece of the curve. Arcs of paths are left out. So are lines of
// paths that are a single point or no larger than `dust` (m).
std::vector<std::vector<Eigen::Vector2d>> sample_curve(const cut::Curve& curve, int samples, double dust = 0.0);

}  // namespace kerf::audit
