#include "server/core/fem/element/bending.h"

#include "server/core/fem/element/bending_lanes.h"

namespace kerf::fem {

Eigen::Vector2d clamp_arm(const std::array<Eigen::Vector2d, 3>& corners, std::size_t edge) {
  const Eigen::Vector2d& a = corners[(edge + 1) % 3];
  const Eigen::Vector2d along = (corners[(edge + 2) % 3] - a).normalized();
  const Eigen::Vector2d inward = corners[edge] - a;
  return along.dot(inward) * along - inward;
}

BendingFit fit_bending(const PatchGeometry& patch, const Eigen::Matrix3d& D_inverse) {
  PatchLanes lanes;
  lanes.set(0, patch, Eigen::Matrix3d::Zero(), D_inverse);
  lanes.fit(1);
  return lanes.fit_of(0);
}

}  // namespace kerf::fem
