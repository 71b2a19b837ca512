#include "server/core/fem/element/membrane_curvature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "server/base/elementary.h"

namespace kerf::fem {
namespace {

// Returns a symmetric matrix as a Voigt strain (e11, e22, 2 e12) in material axes. `in_axes` holds the matrix in other
// axes, into which the rotation Q turns those of the material.
Eigen::Vector3d voigt(const Eigen::Matrix2d& Q, const Eigen::Matrix2d& in_axes) {
  const Eigen::Matrix2d e = Q * in_axes * Q.transpose();
  return {e(0, 0), e(1, 1), 2.0 * e(0, 1)};
}

}  // namespace

double membrane_curvature(const Eigen::Matrix3d& C, const Eigen::Vector2d& stretch, double angle) {
  const double c = cosine(angle);
  const double s = sine(angle);
  const Eigen::Matrix2d Q{
      {c, -s},
      {s, c},
  };
  const Eigen::Vector3d stress = C * voigt(Q, Eigen::Matrix2d((stretch.array() - 1.0).matrix().asDiagonal()));
  const Eigen::Matrix2d in_material{
      {stress[0], stress[2]},
      {stress[2], stress[1]},
  };
  const Eigen::Matrix2d sigma = Q.transpose() * in_material * Q;
  const auto over_sums = [&](const Eigen::Matrix2d& m) {
    Eigen::Matrix2d divided;
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) divided(i, j) = 2.0 * m(i, j) / (stretch[i] + stretch[j]);
    }
    return divided;
  };
  std::array<Eigen::Matrix2d, 4> A;
  std::array<Eigen::Matrix2d, 4> dU;
  for (int k = 0; k < 4; ++k) {
    Eigen::Matrix2d& a = A[static_cast<std::size_t>(k)];
    a.setZero();
    a(k / 2, k % 2) = 1.0;
    const Eigen::Matrix2d ua = stretch.asDiagonal() * a;
    dU[static_cast<std::size_t>(k)] = 0.5 * over_sums(ua + ua.transpose());
  }
  Eigen::Matrix4d in_plane;
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t m = 0; m < 4; ++m) {
      const Eigen::Matrix2d product = A[k].transpose() * A[m] - dU[k] * dU[m];
      const Eigen::Matrix2d d2U = over_sums(0.5 * (product + product.transpose()));
      in_plane(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(m)) =
          voigt(Q, dU[k]).dot(C * voigt(Q, dU[m])) + sigma.cwiseProduct(d2U).sum();
    }
  }
  using Solver4 = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>;
  using Solver2 = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>;
  const double across = Solver2(over_sums(sigma), Eigen::EigenvaluesOnly).eigenvalues()[1];
  return std::max(Solver4(in_plane, Eigen::EigenvaluesOnly).eigenvalues()[3], across);
}

double membrane_curvature_bound(const Eigen::Matrix3d& C) {
  constexpr double kIsotropic = 1e-3;  // -, deviation from an isotropic law over C11, up to which that formula is used
                                       // with the deviation added
  const double off = std::max(std::abs(C(0, 0) - C(1, 1)), std::abs(C(0, 0) - C(0, 1) - 2.0 * C(2, 2)));
  const bool is_convex = 2.0 * (kMostStretch - 1.0) * C(0, 1) <= 2.0 * C(2, 2);  // the factor of d2 tr U in the header
                                                                                 // is never positive
  if (C(0, 1) >= 0.0 && is_convex && off < kIsotropic * C(0, 0)) return std::max(C(0, 0), C(1, 1)) + C(0, 1) + off;
  constexpr std::array<double, 5> kStretches{1e-3, kLeastStretch, 0.6, 1.0, kMostStretch};
  constexpr int kAngles = 8;  // per quarter turn
  // -, margin for stretches and angles between those of the net.
  constexpr double kBetween = 1.05;
  double largest = 0.0;
  for (const double first : kStretches) {
    for (const double second : kStretches) {
      if (std::max(first, second) < kLeastStretch) continue;
      for (int i = 0; i <= kAngles; ++i) {
        const double angle = 0.5 * std::numbers::pi * i / kAngles;
        largest = std::max(largest, membrane_curvature(C, {first, second}, angle));
      }
    }
  }
  return kBetween * largest;
}

}  // namespace kerf::fem
