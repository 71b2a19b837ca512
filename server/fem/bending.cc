#include "server/fem/bending.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace kerf::fem {
namespace {

constexpr double kEigenvalueCutOff = 0.001;  // -, of the largest; below it the fit amplifies a near-conic's noise

Eigen::Vector3d quadratic_terms(const Eigen::Vector2d& d) {
  return {0.5 * d.x() * d.x(), 0.5 * d.y() * d.y(), 0.5 * d.x() * d.y()};
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

// The inverse of G on what the conditions that are nearly dependent on others leave: those whose Gram matrix `gram`, of
// unit rows, has eigenvalues below the cut-off. Rows and columns of missing conditions are 0 in both, and in the
// result.
Eigen::Matrix3d pseudo_inverse(Eigen::Matrix3d G, Eigen::Matrix3d gram, const std::array<bool, 3>& has_condition) {
  for (int r = 0; r < 3; ++r) {
    if (!has_condition[static_cast<std::size_t>(r)]) G(r, r) = gram(r, r) = 1.0;  // decides nothing, and goes again
  }
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  if (is_positive_definite(gram - kEigenvalueCutOff * largest_eigenvalue_bound(gram) * Eigen::Matrix3d::Identity())) {
    inverse = symmetric_inverse(G);
  } else {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(gram);
    const Eigen::Vector3d& values = eigen.eigenvalues();  // ascending
    const int first = values[0] > kEigenvalueCutOff * values[2] ? 0 : values[1] > kEigenvalueCutOff * values[2] ? 1 : 2;
    const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> kept = eigen.eigenvectors().rightCols(3 - first);
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> projected = kept.transpose() * G * kept;
    inverse = kept * projected.inverse() * kept.transpose();
  }
  for (int r = 0; r < 3; ++r) {
    if (has_condition[static_cast<std::size_t>(r)]) continue;
    inverse.row(r).setZero();
    inverse.col(r).setZero();
  }
  return inverse;
}

}  // namespace

Eigen::Vector2d clamp_arm(const std::array<Eigen::Vector2d, 3>& corners, std::size_t edge) {
  const Eigen::Vector2d& a = corners[(edge + 1) % 3];
  const Eigen::Vector2d along = (corners[(edge + 2) % 3] - a).normalized();
  const Eigen::Vector2d inward = corners[edge] - a;
  return along.dot(inward) * along - inward;
}

// A quadratic form q and barycentrics lambda of a point X obey q(X) - sum_k lambda_k q(X_k) = -sum_{j<k} lambda_j
// lambda_k q(X_j - X_k): so P is C, products of barycentrics, times the quadratic terms of the edges. Whether
// conditions depend on each other is a matter of C alone and stays the same when the patch is stretched.
BendingFit fit_bending(const PatchGeometry& patch, const Eigen::Matrix3d& D_inverse) {
  const Eigen::Vector2d e1 = patch.corners[1] - patch.corners[0];
  const Eigen::Vector2d e2 = patch.corners[2] - patch.corners[0];
  const double doubled_area = e1.x() * e2.y() - e1.y() * e2.x();
  const double scale = 1.0 / doubled_area;
  BendingFit fit;
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();     // unit rows
  Eigen::Vector3d size = Eigen::Vector3d::Ones();  // by which they were divided
  std::array<bool, 3> has_condition{};
  for (int r = 0; r < 3; ++r) {
    const auto slot = static_cast<std::size_t>(r);
    if (patch.edges[slot] == PatchEdge::kFree) continue;
    has_condition[slot] = true;
    // Of a clamped edge everything is the derivative along its arm, in its middle.
    const bool is_clamped = patch.edges[slot] == PatchEdge::kClamped;
    const Eigen::Vector2d d =
        is_clamped ? clamp_arm(patch.corners, slot) : Eigen::Vector2d(patch.opposite[slot] - patch.corners[0]);
    const double lambda_1 = scale * (d.x() * e2.y() - d.y() * e2.x());
    const double lambda_2 = scale * (e1.x() * d.y() - e1.y() * d.x());
    const Eigen::Vector3d lambda((is_clamped ? 0.0 : 1.0) - lambda_1 - lambda_2, lambda_1, lambda_2);
    fit.conditions.row(r).head<3>() = -lambda;
    fit.conditions(r, 3 + r) = 1.0;
    const Eigen::Vector3d at = is_clamped ? Eigen::Vector3d(0.5 * (Eigen::Vector3d::Ones() - Eigen::Vector3d::Unit(r)))
                                          : Eigen::Vector3d(0.5 * lambda);
    const Eigen::Vector3d products(lambda[1] * at[2] + at[1] * lambda[2], lambda[2] * at[0] + at[2] * lambda[0],
                                   lambda[0] * at[1] + at[0] * lambda[1]);
    size[r] = products.norm();
    C.row(r) = products / size[r];
  }
  Eigen::Matrix3d Phi;
  Phi << quadratic_terms(e2 - e1), quadratic_terms(e2), quadratic_terms(e1);
  const Eigen::Matrix3d CPhi = C * Phi.transpose();
  const Eigen::Matrix3d G = CPhi * D_inverse * CPhi.transpose();
  const Eigen::Matrix3d inverse = pseudo_inverse(G, C * C.transpose(), has_condition);
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      fit.law(i, j) = fit.law(j, i) = 0.5 * doubled_area / (size[i] * size[j]) * inverse(i, j);
    }
  }
  // P = -diag(size) C Phi.
  fit.moments = CPhi.transpose() * inverse;
  for (int j = 0; j < 3; ++j) fit.moments.col(j) *= -1.0 / size[j];
  return fit;
}

std::array<double, 21> bending_stiffness(const BendingFit& fit) {
  const Eigen::Matrix3d L = fit.conditions.leftCols<3>();
  const Eigen::Matrix3d ML = fit.law * L;
  const auto entry = [&](int i, int j) {  // i <= j
    if (i >= 3) return fit.law(i - 3, j - 3);
    return j >= 3 ? ML(j - 3, i) : L.col(i).dot(ML.col(j));
  };
  std::array<double, 21> upper{};
  std::size_t at = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) upper[at++] = entry(i, j);
  }
  return upper;
}

}  // namespace kerf::fem
