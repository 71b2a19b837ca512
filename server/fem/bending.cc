#include "server/fem/bending.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace kerf::fem {
namespace {

constexpr double kEigenvalueCutOff = 0.02;  // -, of the largest; below it the fit amplifies a near-conic's noise

Eigen::Vector3d quadratic_terms(const Eigen::Vector2d& d) {
  return {0.5 * d.x() * d.x(), 0.5 * d.y() * d.y(), 0.5 * d.x() * d.y()};
}

// The derivative of quadratic_terms at d along `arm`.
Eigen::Vector3d quadratic_slopes(const Eigen::Vector2d& d, const Eigen::Vector2d& arm) {
  return {d.x() * arm.x(), d.y() * arm.y(), 0.5 * (d.x() * arm.y() + d.y() * arm.x())};
}

// Inverse of a symmetric matrix by its cofactors.
Eigen::Matrix3d symmetric_inverse(const Eigen::Matrix3d& G) {
  const double scale = 1.0 / G.determinant();
  const double i00 = scale * (G(1, 1) * G(2, 2) - G(1, 2) * G(1, 2));
  const double i01 = scale * (G(0, 2) * G(1, 2) - G(0, 1) * G(2, 2));
  const double i02 = scale * (G(0, 1) * G(1, 2) - G(0, 2) * G(1, 1));
  const double i11 = scale * (G(0, 0) * G(2, 2) - G(0, 2) * G(0, 2));
  const double i12 = scale * (G(0, 1) * G(0, 2) - G(0, 0) * G(1, 2));
  const double i22 = scale * (G(0, 0) * G(1, 1) - G(0, 1) * G(0, 1));
  return Eigen::Matrix3d{
      {i00, i01, i02},
      {i01, i11, i12},
      {i02, i12, i22},
  };
}

// Of a symmetric matrix; at most a third above it where all eigenvalues are positive (Wolkowicz and Styan 1980, "Bounds
// for eigenvalues using traces": mean + sqrt(2) standard deviations).
double largest_eigenvalue_bound(const Eigen::Matrix3d& G) {
  const double mean = G.trace() / 3.0;
  return mean + std::sqrt(2.0 * std::max(0.0, G.squaredNorm() / 3.0 - mean * mean));
}

bool is_positive_definite(const Eigen::Matrix3d& G) {
  return G(0, 0) > 0.0 && G(0, 0) * G(1, 1) > G(0, 1) * G(0, 1) && G.determinant() > 0.0;
}

// Pseudo-inverse of a symmetric positive semidefinite matrix whose rows and columns of missing conditions are zero.
Eigen::Matrix3d pseudo_inverse(Eigen::Matrix3d G, const std::array<bool, 3>& has_condition) {
  // The mean of the other eigenvalues in place of a missing condition's decides nothing, and goes again.
  const int num_conditions = (has_condition[0] ? 1 : 0) + (has_condition[1] ? 1 : 0) + (has_condition[2] ? 1 : 0);
  if (num_conditions == 0) return Eigen::Matrix3d::Zero();
  const double mean = G.trace() / num_conditions;
  for (int r = 0; r < 3; ++r) {
    if (!has_condition[static_cast<std::size_t>(r)]) G(r, r) = mean;
  }
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  if (is_positive_definite(G - kEigenvalueCutOff * largest_eigenvalue_bound(G) * Eigen::Matrix3d::Identity())) {
    inverse = symmetric_inverse(G);
  } else {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(G);
    const Eigen::Vector3d& values = eigen.eigenvalues();  // ascending
    for (int i = 0; i < 3; ++i) {
      if (values[i] <= kEigenvalueCutOff * values[2] || values[i] <= 0.0) continue;
      const Eigen::Vector3d q = eigen.eigenvectors().col(i);
      inverse += (1.0 / values[i]) * (q * q.transpose());
    }
  }
  for (int r = 0; r < 3; ++r) {
    if (has_condition[static_cast<std::size_t>(r)]) continue;
    inverse.row(r).setZero();
    inverse.col(r).setZero();
  }
  return inverse;
}

// BendingFit without the part of its conditions that is the identity.
struct Fit {
  Eigen::Matrix3d L =
      Eigen::Matrix3d::Zero();  // row r: barycentrics of neighbour r's vertex; w = x_opposite - L x_corners
  Eigen::Matrix3d M;            // N/m; the law

  Fit(const std::array<Eigen::Vector2d, 3>& corners, const std::array<Eigen::Vector2d, 3>& opposite,
      const std::array<PatchEdge, 3>& edges, const Eigen::Matrix3d& D_inverse) {
    const Eigen::Vector2d e1 = corners[1] - corners[0];
    const Eigen::Vector2d e2 = corners[2] - corners[0];
    const double doubled_area = e1.x() * e2.y() - e1.y() * e2.x();
    const double scale = 1.0 / doubled_area;
    const Eigen::Vector3d quadratic_1 = quadratic_terms(e1);
    const Eigen::Vector3d quadratic_2 = quadratic_terms(e2);
    Eigen::Matrix3d Pt = Eigen::Matrix3d::Zero();  // column r: condition of neighbour r on the curvature
    for (int r = 0; r < 3; ++r) {
      const auto slot = static_cast<std::size_t>(r);
      if (edges[slot] == PatchEdge::kFree) continue;
      const bool is_clamped = edges[slot] == PatchEdge::kClamped;
      // Of a clamped edge everything is the derivative along this.
      const Eigen::Vector2d d = is_clamped ? clamp_arm(corners, slot) : Eigen::Vector2d(opposite[slot] - corners[0]);
      const double lambda_1 = scale * (d.x() * e2.y() - d.y() * e2.x());
      const double lambda_2 = scale * (e1.x() * d.y() - e1.y() * d.x());
      L(r, 0) = (is_clamped ? 0.0 : 1.0) - lambda_1 - lambda_2;
      L(r, 1) = lambda_1;
      L(r, 2) = lambda_2;
      const Eigen::Vector2d middle = 0.5 * (corners[(slot + 1) % 3] + corners[(slot + 2) % 3]) - corners[0];
      const Eigen::Vector3d terms = is_clamped ? quadratic_slopes(middle, d) : quadratic_terms(d);
      Pt.col(r) = terms - lambda_1 * quadratic_1 - lambda_2 * quadratic_2;
    }
    const std::array<bool, 3> has_condition{edges[0] != PatchEdge::kFree, edges[1] != PatchEdge::kFree,
                                            edges[2] != PatchEdge::kFree};
    const Eigen::Matrix3d D_inverse_Pt = D_inverse * Pt;
    Eigen::Matrix3d G;
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) G(i, j) = G(j, i) = Pt.col(i).dot(D_inverse_Pt.col(j));
    }
    M = 0.5 * doubled_area * pseudo_inverse(G, has_condition);
  }
};

}  // namespace

Eigen::Vector2d clamp_arm(const std::array<Eigen::Vector2d, 3>& corners, std::size_t edge) {
  const Eigen::Vector2d& a = corners[(edge + 1) % 3];
  const Eigen::Vector2d along = (corners[(edge + 2) % 3] - a).normalized();
  const Eigen::Vector2d inward = corners[edge] - a;
  return along.dot(inward) * along - inward;
}

std::array<double, 21> bending_stiffness(const std::array<Eigen::Vector2d, 3>& corners,
                                         const std::array<Eigen::Vector2d, 3>& opposite,
                                         const std::array<PatchEdge, 3>& edges, const Eigen::Matrix3d& D_inverse) {
  const Fit fit(corners, opposite, edges, D_inverse);
  const Eigen::Matrix3d ML = fit.M * fit.L;
  const auto entry = [&](int i, int j) {  // i <= j
    if (i >= 3) return fit.M(i - 3, j - 3);
    return j >= 3 ? -ML(j - 3, i) : fit.L.col(i).dot(ML.col(j));
  };
  std::array<double, 21> upper{};
  std::size_t at = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) upper[at++] = entry(i, j);
  }
  return upper;
}

BendingFit fit_bending(const std::array<Eigen::Vector2d, 3>& corners, const std::array<Eigen::Vector2d, 3>& opposite,
                       const std::array<PatchEdge, 3>& edges, const Eigen::Matrix3d& D_inverse) {
  const Fit fit(corners, opposite, edges, D_inverse);
  BendingFit made;
  made.law = fit.M;
  made.conditions.leftCols<3>() = -fit.L;
  for (int r = 0; r < 3; ++r)
    made.conditions(r, 3 + r) = edges[static_cast<std::size_t>(r)] != PatchEdge::kFree ? 1.0 : 0.0;
  return made;
}

}  // namespace kerf::fem
