#include "server/core/fem/element/hinge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "server/base/elementary.h"
#include "server/core/fem/element/rest_bending.h"
#include "server/core/linear/cross_matrix.h"

namespace kerf::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

// Signs of the two corners opposite the edge. The normals of both triangles point to the same side, although the second
// corner is to the right of the edge.
constexpr std::array<double, 2> kSign{1.0, -1.0};

}  // namespace

Hinge::Hinge(const std::array<Vector3d, 4>& x, const HingeSize& rest) : edge_(x[1] - x[0]) {
  const double least_length = std::max(kLeastArea * rest.length, std::numeric_limits<double>::min());
  squared_ = edge_.squaredNorm();
  length_ = std::sqrt(squared_);
  is_short_ = !(squared_ > least_length * least_length);
  if (is_short_) {
    squared_ = least_length * least_length;
    share_ = length_ / least_length * (length_ / least_length);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    wings_[i] = make_wing(x[2 + i] - x[0], kSign[i], kLeastArea * rest.length * rest.height[i]);
  }
  // Each wing also gets the share of the other one. Their torques cancel only if both have the same factor.
  for (std::size_t i = 0; i < 2; ++i) wings_[i].share = wings_[1 - i].own_share;
  for (Wing& wing : wings_) wing.rate *= wing.share;
  if (wings_[0].unit.isZero(0.0) || wings_[1].unit.isZero(0.0)) return;
  // Exact at small angles and near pi, unlike an arc cosine.
  theta_ = 2.0 * arc_tangent((wings_[0].unit - wings_[1].unit).norm(), (wings_[0].unit + wings_[1].unit).norm());
  if (wings_[0].unit.dot(wings_[1].corner) < 0.0) theta_ = -theta_;
}

Hinge::Wing Hinge::make_wing(const Vector3d& corner, double sign, double least) const {
  Wing wing;
  wing.corner = corner;
  wing.normal = sign * edge_.cross(corner);
  const double size = wing.normal.norm();
  wing.has_collapsed = !(size > least);
  const double counted = std::max({size, least, std::numeric_limits<double>::min()});
  wing.over_squared = 1.0 / (counted * counted);
  if (size > 0.0) wing.unit = wing.normal / size;
  const double part = std::min(1.0, size / counted);
  wing.own_share = part * part;
  wing.rate = length_ / counted * part * wing.unit;
  const double foot = edge_.dot(corner) / squared_;
  wing.weight = {foot - share_, -foot, share_};
  return wing;
}

std::array<Vector3d, 4> Hinge::gradient() const {
  std::array<Vector3d, 4> made;
  for (std::size_t k = 0; k < 2; ++k) {
    made[k] = wings_[0].weight[k] * wings_[0].rate + wings_[1].weight[k] * wings_[1].rate;
  }
  made[2] = wings_[0].weight[2] * wings_[0].rate;
  made[3] = wings_[1].weight[2] * wings_[1].rate;
  return made;
}

// Adds the derivatives of rate weight^T.
void Hinge::add_second_derivatives(const Wing& wing, double sign, std::size_t corner, Matrix12d& sum) const {
  const Vector3d direction = length_ > 0.0 ? Vector3d(edge_ / length_) : Vector3d(Vector3d::Zero());
  Matrix3d by_normal = Matrix3d::Identity();
  if (!wing.has_collapsed) by_normal -= 2.0 * wing.unit * wing.unit.transpose();
  by_normal *= wing.share * length_ * wing.over_squared;
  const Matrix3d by_length = wing.share * wing.over_squared * wing.normal * direction.transpose();
  // Derivatives by the edge and by the corner, both relative to the beginning of the edge.
  const Matrix3d rate_by_edge = by_length - sign * by_normal * linear::cross_matrix(wing.corner);
  const Matrix3d rate_by_corner = sign * by_normal * linear::cross_matrix(edge_);
  const double foot = -wing.weight[1];
  Vector3d foot_by_edge = wing.corner / squared_;
  if (!is_short_) foot_by_edge -= 2.0 * foot * edge_ / squared_;
  const Vector3d foot_by_corner = edge_ / squared_;
  const std::array<Matrix3d, 3> rate_by{-rate_by_edge - rate_by_corner, rate_by_edge, rate_by_corner};
  const std::array<Vector3d, 3> foot_by{-foot_by_edge - foot_by_corner, foot_by_edge, foot_by_corner};
  constexpr std::array<double, 3> kWeightByFoot{1.0, -1.0, 0.0};
  const std::array<std::size_t, 3> point{0, 1, corner};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t l = 0; l < 3; ++l) {
      sum.block<3, 3>(static_cast<Eigen::Index>(3 * point[k]), static_cast<Eigen::Index>(3 * point[l])) +=
          wing.weight[k] * rate_by[l] + kWeightByFoot[k] * wing.rate * foot_by[l].transpose();
    }
  }
}

Matrix12d Hinge::hessian() const {
  Matrix12d sum = Matrix12d::Zero();
  for (std::size_t i = 0; i < 2; ++i) add_second_derivatives(wings_[i], kSign[i], 2 + i, sum);
  // Symmetric except for rounding and collapsed triangles.
  return 0.5 * (sum + sum.transpose());
}

}  // namespace kerf::fem
