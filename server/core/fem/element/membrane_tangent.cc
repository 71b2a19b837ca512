#include "server/core/fem/element/membrane_tangent.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace kerf::fem {
namespace {

// Returns the nearest positive semidefinite matrix to a symmetric 2x2 one: eigenvalues are cut at 0, in closed form.
Eigen::Matrix2d positive_part(const Eigen::Matrix2d& A) {
  const double mean = 0.5 * (A(0, 0) + A(1, 1));
  const double half = 0.5 * (A(0, 0) - A(1, 1));
  const double radius = std::sqrt(half * half + A(0, 1) * A(1, 0));
  const double low = mean - radius;
  const double high = mean + radius;
  if (low >= 0.0) return A;
  if (high <= 0.0) return Eigen::Matrix2d::Zero();
  // A = high P + low (I - P) with the projector P on the upper eigenvector.
  return (high / (high - low)) * (A - low * Eigen::Matrix2d::Identity());
}

}  // namespace

MembraneTangent::MembraneTangent(const ElementBlock& block, std::size_t lane, const LaneFrames& frames,
                                 const MaterialTable& materials)
    : law_(materials.membrane_law()),
      area_(block.area[lane]),
      C_(materials.of(block, lane).membrane),
      inverse_trace_(frames.inverse_trace[lane]) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    R_(static_cast<Eigen::Index>(axis), 0) = frames.R1[axis][lane];
    R_(static_cast<Eigen::Index>(axis), 1) = frames.R2[axis][lane];
  }
  n_ = R_.col(0).cross(R_.col(1));
  S_(0, 0) = frames.S11[lane];
  S_(1, 1) = frames.S22[lane];
  S_(0, 1) = frames.S12[lane];
  S_(1, 0) = frames.S12[lane];
  g_.col(1) = Eigen::Vector2d(block.g1[0][lane], block.g1[1][lane]);
  g_.col(2) = Eigen::Vector2d(block.g2[0][lane], block.g2[1][lane]);
  g_.col(0) = -g_.col(1) - g_.col(2);
  law_ == MembraneLaw::kGreen ? set_green() : set_corotational();
}

void MembraneTangent::set_corotational() {
  e_ = Eigen::Vector3d(S_(0, 0) - 1.0, S_(1, 1) - 1.0, 2.0 * S_(0, 1));
  const double S12 = S_(0, 1);
  const double difference = S_(1, 1) - S_(0, 0);
  for (int k = 0; k < 3; ++k) {
    const double gx = g_(0, k);
    const double gy = g_(1, k);
    const double wu = -gy * inverse_trace_;
    const double wv = gx * inverse_trace_;
    w_(2 * k) = wu;
    w_(2 * k + 1) = wv;
    B_.col(2 * k) = Eigen::Vector3d(gx + wu * S12, -wu * S12, gy + wu * difference);
    B_.col(2 * k + 1) = Eigen::Vector3d(wv * S12, gy - wv * S12, gx + wv * difference);
  }
}

void MembraneTangent::set_green() {
  const Eigen::Matrix2d E = 0.5 * (S_ * S_ - Eigen::Matrix2d::Identity());
  e_ = Eigen::Vector3d(E(0, 0), E(1, 1), 2.0 * E(0, 1));
  w_.setZero();
  for (int k = 0; k < 3; ++k) {
    const double gx = g_(0, k);
    const double gy = g_(1, k);
    for (int axis = 0; axis < 2; ++axis) {
      B_.col(2 * k + axis) = Eigen::Vector3d(S_(0, axis) * gx, S_(1, axis) * gy, S_(0, axis) * gy + S_(1, axis) * gx);
    }
  }
}

Eigen::Vector3d MembraneTangent::predicted_stress(const ElementVector& dx) const {
  Eigen::Vector3d e = e_;
  for (int k = 0; k < 3; ++k) e += B_.middleCols<2>(2 * k) * (R_.transpose() * dx.segment<3>(3 * k));
  return C_ * e;
}

MembraneTangent::Geometric MembraneTangent::corotational_part(const Eigen::Vector3d& sigma) const {
  constexpr double kCollapsed = 1e-12;  // -, det S over (tr S)^2 below which S has no useful inverse
  Geometric result;
  const double a = (S_(0, 1) * (sigma[0] - sigma[1]) + sigma[2] * (S_(1, 1) - S_(0, 0))) * inverse_trace_;
  const Eigen::Matrix2d T{
      {sigma[0], sigma[2] - a},
      {sigma[2] + a, sigma[1]},
  };
  result.gamma = sigma[0] * S_(0, 0) + sigma[1] * S_(1, 1) + 2.0 * sigma[2] * S_(0, 1);
  result.c = Eigen::RowVector3d(-2.0 * T(1, 0), 2.0 * T(0, 1), T(0, 0) - T(1, 1));
  const double trace = S_.trace();
  const double det = S_.determinant();
  if (det > kCollapsed * trace * trace) {
    const Eigen::Matrix2d Sigma = ((trace * Eigen::Matrix2d::Identity() - S_) / det) * T;
    result.Sigma = 0.5 * (Sigma + Sigma.transpose());
  }
  return result;
}

MembraneTangent::Geometric MembraneTangent::geometric(const Eigen::Vector3d& sigma, bool project) const {
  Geometric result;
  if (law_ == MembraneLaw::kGreen) {
    result.Sigma = Eigen::Matrix2d{
        {sigma[0], sigma[2]},
        {sigma[2], sigma[1]},
    };
  } else {
    result = corotational_part(sigma);
  }
  if (!project) return result;
  result.Sigma = positive_part(result.Sigma);
  if (result.gamma <= 0.0) {
    result.gamma = 0.0;
    result.c.setZero();
    return result;
  }
  const double needed = 0.25 * result.c.dot(C_.inverse() * result.c.transpose());
  if (needed > result.gamma) result.c *= std::sqrt(result.gamma / needed);
  return result;
}

void MembraneTangent::stiffness(const Eigen::Vector3d& sigma, double material_scale, double geometric_scale,
                                bool project, ElementMatrix& K) const {
  const Geometric part = geometric(sigma, project);
  const Eigen::Matrix<double, 1, 6> cB = part.c * B_;
  Eigen::Matrix<double, 6, 6> K_in = material_scale * (B_.transpose() * (C_ * B_));
  K_in += geometric_scale * (part.gamma * (w_.transpose() * w_) + 0.5 * (w_.transpose() * cB + cB.transpose() * w_));
  const Eigen::Matrix3d K_out = geometric_scale * (g_.transpose() * (part.Sigma * g_));
  const Eigen::Matrix3d nn = n_ * n_.transpose();
  const bool is_green = law_ == MembraneLaw::kGreen;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      Eigen::Matrix2d in_plane = K_in.block<2, 2>(2 * i, 2 * j);
      if (is_green) in_plane.diagonal().array() += K_out(i, j);
      const Eigen::Matrix3d K_ij = area_ * (R_ * (in_plane * R_.transpose()) + K_out(i, j) * nn);
      K.block<3, 3>(3 * i, 3 * j) = K_ij;
      if (j > i) K.block<3, 3>(3 * j, 3 * i) = K_ij.transpose();
    }
  }
}

void predict_stress(std::span<const ElementBlock> blocks, const MaterialTable& materials, const linear::VertexField& x,
                    const linear::VertexField& step, std::span<Eigen::Vector3d> sigma) {
  LaneFrames frames;
  ElementVector dx;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    frames_at(blocks[b], x, frames);
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (blocks[b].area[l] == 0.0) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        dx.segment<3>(static_cast<Eigen::Index>(3 * k)) = step.col(blocks[b].vertex[k][l]);
      }
      sigma[b * kLanes + l] = MembraneTangent(blocks[b], l, frames, materials).predicted_stress(dx);
    }
  }
}

}  // namespace kerf::fem
