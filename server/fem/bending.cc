#include "server/fem/bending.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace kerf::fem {
namespace {

constexpr double kEigenvalueCutOff = 0.02;  // -, of the largest; below it the fit amplifies a near-conic's noise

Eigen::Vector3d quadratic_terms(const Eigen::Vector2d& d) {
  return {0.5 * d.x() * d.x(), 0.5 * d.y() * d.y(), 0.5 * d.x() * d.y()};
}

// Barycentric coordinates of X in the triangle.
Eigen::Vector3d barycentric(const std::array<Eigen::Vector2d, 3>& corners, const Eigen::Vector2d& X) {
  const Eigen::Vector2d e1 = corners[1] - corners[0];
  const Eigen::Vector2d e2 = corners[2] - corners[0];
  const Eigen::Vector2d d = X - corners[0];
  const double det = e1.x() * e2.y() - e1.y() * e2.x();
  const double l1 = (d.x() * e2.y() - d.y() * e2.x()) / det;
  const double l2 = (e1.x() * d.y() - e1.y() * d.x()) / det;
  return {1.0 - l1 - l2, l1, l2};
}

// Pseudo-inverse of a symmetric positive semidefinite matrix whose rows and columns of missing neighbours are zero.
Eigen::Matrix3d pseudo_inverse(const Eigen::Matrix3d& G) {
  // The common case without its eigenvalues: det = l1 l2 l3 and l2 + l3 <= trace give l1 >= 4 det / trace^2, and l3 is
  // no larger than the trace, so that none of them is cut off here.
  const double trace = G.trace();
  const double determinant = G.determinant();
  if (4.0 * determinant > kEigenvalueCutOff * trace * trace * trace) return G.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(G);
  const Eigen::Vector3d& values = eigen.eigenvalues();  // ascending
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    if (values[i] <= kEigenvalueCutOff * values[2] || values[i] <= 0.0) continue;
    const Eigen::Vector3d q = eigen.eigenvectors().col(i);
    inverse += (1.0 / values[i]) * (q * q.transpose());
  }
  return inverse;
}

// Rows of the fit, one a neighbour.
struct Conditions {
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();                          // on the curvature
  Eigen::Matrix<double, 3, 6> W = Eigen::Matrix<double, 3, 6>::Zero();  // w = W x

  Conditions(const std::array<Eigen::Vector2d, 3>& corners, const std::array<Eigen::Vector2d, 3>& opposite,
             const std::array<bool, 3>& has_opposite) {
    for (int r = 0; r < 3; ++r) {
      const auto slot = static_cast<std::size_t>(r);
      if (!has_opposite[slot]) continue;
      const Eigen::Vector3d lambda = barycentric(corners, opposite[slot]);
      Eigen::Vector3d p = quadratic_terms(opposite[slot] - corners[0]);
      for (int k = 0; k < 3; ++k) {
        p -= lambda[k] * quadratic_terms(corners[static_cast<std::size_t>(k)] - corners[0]);
        W(r, k) = -lambda[k];
      }
      W(r, 3 + r) = 1.0;
      P.row(r) = p.transpose();
    }
  }
};

double area_of(const std::array<Eigen::Vector2d, 3>& corners) {
  const Eigen::Vector2d e1 = corners[1] - corners[0];
  const Eigen::Vector2d e2 = corners[2] - corners[0];
  return 0.5 * (e1.x() * e2.y() - e1.y() * e2.x());
}

}  // namespace

std::array<double, 21> bending_stiffness(const std::array<Eigen::Vector2d, 3>& corners,
                                         const std::array<Eigen::Vector2d, 3>& opposite,
                                         const std::array<bool, 3>& has_opposite, const Eigen::Matrix3d& D,
                                         const Eigen::Matrix3d& D_inverse) {
  using Matrix36 = Eigen::Matrix<double, 3, 6>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const Conditions fit(corners, opposite, has_opposite);
  const Eigen::Matrix3d D_inverse_Pt = D_inverse * fit.P.transpose();
  const Matrix36 B = D_inverse_Pt * (pseudo_inverse(fit.P * D_inverse_Pt) * fit.W);
  const Matrix6 Q = area_of(corners) * (B.transpose() * (D * B));
  std::array<double, 21> upper{};
  std::size_t at = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) upper[at++] = 0.5 * (Q(i, j) + Q(j, i));
  }
  return upper;
}

BendingFit fit_bending(const std::array<Eigen::Vector2d, 3>& corners, const std::array<Eigen::Vector2d, 3>& opposite,
                       const std::array<bool, 3>& has_opposite, const Eigen::Matrix3d& D_inverse) {
  const Conditions fit(corners, opposite, has_opposite);
  return {fit.W, area_of(corners) * pseudo_inverse(fit.P * (D_inverse * fit.P.transpose()))};
}

}  // namespace kerf::fem
