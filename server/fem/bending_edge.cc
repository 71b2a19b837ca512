#include "server/fem/bending_edge.h"

#include <algorithm>
#include <cmath>

namespace kerf::fem {

BendingSide bending_side(const PatchGeometry& patch, const BendingFit& fit, const Eigen::Matrix3d& D,
                         const Eigen::Matrix3d& D_inverse, std::size_t edge) {
  const Eigen::Vector2d& a = patch.corners[(edge + 1) % 3];
  const Eigen::Vector2d& b = patch.corners[(edge + 2) % 3];
  const Eigen::Vector2d middle = 0.5 * (a + b);
  const Eigen::Vector2d arm = clamp_arm(patch.corners, edge);
  const double height = arm.norm();
  const Eigen::Vector2d n = arm / height;
  BendingSide side;
  side.length = (b - a).norm();

  // Derivatives of the barycentrics along n, and what they leave of a quadratic about the middle of the edge.
  const Eigen::Vector2d along = (b - a) / side.length;
  const double foot = along.dot(patch.corners[edge] - a) / side.length;  // of the height, from a to b
  std::array<double, 3> rate{};
  rate[edge] = -1.0 / height;
  rate[(edge + 1) % 3] = (1.0 - foot) / height;
  rate[(edge + 2) % 3] = foot / height;
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector2d d = patch.corners[k] - middle;
    rest += rate[k] * Eigen::Vector3d(0.5 * d.x() * d.x(), 0.5 * d.y() * d.y(), 0.5 * d.x() * d.y());
  }
  const Eigen::Vector3d nn(n.x() * n.x(), n.y() * n.y(), 2.0 * n.x() * n.y());
  const Eigen::RowVector3d slope_of_w = -rest.transpose() * D_inverse * fit.moments;
  const Eigen::RowVector3d moment_of_w = nn.transpose() * fit.moments;
  for (std::size_t i = 0; i < 6; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    side.slope[i] = slope_of_w.dot(fit.conditions.col(column)) + (i < 3 ? rate[i] : 0.0);
    side.moment[i] = moment_of_w.dot(fit.conditions.col(column));
  }
  side.penalty = kKinkPenalty * side.length * nn.dot(D * nn) / (2.0 * height);  // A = l h / 2
  return side;
}

std::array<std::size_t, 6> places_of_second(std::size_t first_edge, std::size_t second_edge) {
  const std::size_t next = (second_edge + 1) % 3;
  const std::size_t last = (second_edge + 2) % 3;
  std::array<std::size_t, 6> places{};
  places[second_edge] = 3 + first_edge;
  places[next] = (first_edge + 2) % 3;
  places[last] = (first_edge + 1) % 3;
  places[3 + second_edge] = first_edge;
  places[3 + next] = 6;
  places[3 + last] = 7;
  return places;
}

bool join_sides(const BendingSide& first, const BendingSide& second, const std::array<std::size_t, 6>& places,
                BendingEdge& made) {
  made.kink.fill(0.0);
  made.load.fill(0.0);
  // Both slopes are outward ones: the jump from the first side to the second is minus their sum.
  for (std::size_t i = 0; i < 6; ++i) {
    made.kink[i] -= first.slope[i];
    made.load[i] += 0.5 * first.length * first.moment[i];
  }
  for (std::size_t i = 0; i < 6; ++i) {
    made.kink[places[i]] -= second.slope[i];
    made.load[places[i]] += 0.5 * first.length * second.moment[i];
  }
  double largest = 0.0;
  for (const double kink : made.kink) largest = std::max(largest, std::abs(kink));
  if (!(largest * first.length > kNegligibleKink)) return false;
  const double penalty = first.penalty + second.penalty;
  for (std::size_t i = 0; i < 8; ++i) made.load[i] += penalty * made.kink[i];
  // Around an inner vertex of three triangles one vertex is across two edges.
  for (std::size_t i = 7; i > 0; --i) {
    const auto same = std::find(made.vertex.begin(), made.vertex.end(), made.vertex[i]);
    const auto at = static_cast<std::size_t>(same - made.vertex.begin());
    if (made.vertex[i] == mesh::kNone || at == i) continue;
    made.kink[at] += made.kink[i];
    made.load[at] += made.load[i];
    made.vertex[i] = mesh::kNone;
    made.kink[i] = made.load[i] = 0.0;
  }
  return true;
}

}  // namespace kerf::fem
