#include "server/core/fem/element/majorized_membrane.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace kerf::fem {
namespace {

// Returns C e of a symmetric e, both as matrices.
Eigen::Matrix2d stress_of(const Eigen::Matrix3d& C, const Eigen::Matrix2d& e) {
  const Eigen::Vector3d sigma = C * Eigen::Vector3d(e(0, 0), e(1, 1), 2.0 * e(0, 1));
  return Eigen::Matrix2d{
      {sigma[0], sigma[2]},
      {sigma[2], sigma[1]},
  };
}

// Returns z, N/m; see the header.
double least_pull(const Eigen::Matrix3d& C, const Eigen::Matrix2d& V) {
  const double k = 4.0 * C(2, 2) + 2.0 * C(0, 1) - C(0, 0) - C(1, 1);
  const double a = 0.5 * std::max(0.0, k);
  const double b = std::max(0.0, -C(0, 1));
  return std::max(C(0, 0) + a * V(0, 0), C(1, 1) + a * V(1, 1)) + C(0, 1) + b * V.trace();
}

}  // namespace

MajorizedTriangle::MajorizedTriangle(const ElementBlock& block, std::size_t lane, const LaneFrames& frames,
                                     const MaterialTable& materials)
    : area_(block.area[lane]) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    R_(static_cast<Eigen::Index>(axis), 0) = frames.R1[axis][lane];
    R_(static_cast<Eigen::Index>(axis), 1) = frames.R2[axis][lane];
  }
  const Eigen::Matrix2d S{
      {frames.S11[lane], frames.S12[lane]},
      {frames.S12[lane], frames.S22[lane]},
  };
  F_ = R_ * S;
  g_.col(1) = Eigen::Vector2d(block.g1[0][lane], block.g1[1][lane]);
  g_.col(2) = Eigen::Vector2d(block.g2[0][lane], block.g2[1][lane]);
  g_.col(0) = -g_.col(1) - g_.col(2);

  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(S);
  const Eigen::Matrix2d& Q = eigen.eigenvectors();
  const double least = kLeastStretch * std::max(1.0, eigen.eigenvalues()[1]);
  const Eigen::Vector2d v = eigen.eigenvalues().cwiseMax(least);
  const Eigen::Matrix2d V = Q * v.asDiagonal() * Q.transpose();
  const Eigen::Matrix3d& C = materials.of(block, lane).membrane;
  const Eigen::Matrix2d strain = V - Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d sigma = stress_of(C, strain);
  z_ = least_pull(C, V);
  Eigen::Matrix2d H = Q.transpose() * (z_ * Eigen::Matrix2d::Identity() + sigma) * Q;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) H(i, j) /= v[i] + v[j];
  }
  H_ = Q * H * Q.transpose();
  // From q(R V) = W(R V).
  constant_ = 0.5 * sigma.cwiseProduct(strain).sum() - H_.cwiseProduct(V * V).sum() + z_ * V.trace();
}

double MajorizedTriangle::energy(const Matrix32& F) const {
  return area_ * ((F * H_).cwiseProduct(F).sum() - z_ * R_.cwiseProduct(F).sum() + constant_);
}

Eigen::Vector3d MajorizedTriangle::force(int corner) const {
  return -area_ * ((2.0 * F_ * H_ - z_ * R_) * g_.col(corner));
}

void add_majorized_forces(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                          const linear::VertexField& x, linear::VertexField& f) {
  LaneFrames frames;
  for (const ElementBlock& block : blocks) {
    frames_at(block, x, frames);
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (block.area[l] == 0.0) continue;
      const MajorizedTriangle triangle(block, l, frames, materials);
      for (int k = 0; k < 3; ++k) f.col(block.vertex[static_cast<std::size_t>(k)][l]) += triangle.force(k);
    }
  }
}

}  // namespace kerf::fem
