#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Bending stiffness of one triangle, from a quadratic fitted through its corners and the opposite corners of its up to
// three neighbours. For a flat rest shape the curvature is linear in the positions, kappa = B x, so that the energy is
//   E = A/2 sum over x,y,z of kappa.D kappa = 1/2 x.Q x,   Q = A B^T D B  (times the 3x3 identity).
// Q is constant, positive semidefinite, and invariant under translation and rotation. A missing neighbour just drops
// its condition, which is the natural condition of a free edge.
struct BendingPatch {
  // 0..2 are corners; 3 + k is the vertex across the edge opposite corner k, or kNone.
  std::array<mesh::VertexId, 6> vertex{mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone};
  // Upper triangle of Q by rows, N/m. Rows and columns of missing vertices are zero, except those of clamped edges.
  std::array<double, 21> stiffness{};

  [[nodiscard]] double at(int a, int b) const { return stiffness[kPlace[static_cast<std::size_t>(6 * a + b)]]; }

  // Index of entry (a, b), at 6 a + b, in an upper triangle by rows.
  static constexpr std::array<std::uint8_t, 36> kPlace{0, 1, 2,  3,  4,  5,  1, 6,  7,  8,  9,  10,
                                                       2, 7, 11, 12, 13, 14, 3, 8,  12, 15, 16, 17,
                                                       4, 9, 13, 16, 18, 19, 5, 10, 14, 17, 19, 20};
};

// One entry of a row of the assembled Q.
struct BendingEntry {
  double value = 0.0;  // N/m
  mesh::VertexId column = mesh::kNone;
  bool operator==(const BendingEntry&) const = default;
};

// The fit of a patch: w = conditions x, with a zero row for a missing neighbour, and E = 1/2 w.law w. Hence Q =
// conditions^T law conditions.
struct BendingFit {
  Eigen::Matrix<double, 3, 6> conditions = Eigen::Matrix<double, 3, 6>::Zero();  // -
  Eigen::Matrix3d law = Eigen::Matrix3d::Zero();                                 // N/m
};

// Kind of a triangle's edge: free, shared with a neighbour, or clamped. A clamp holds the slope of the sheet across a
// border edge.
enum class PatchEdge : std::uint8_t { kFree, kNeighbour, kClamped };

// Rest geometry of a patch, m, material axes. `corners` are counter-clockwise. opposite[k] is the vertex across the
// edge opposite corner k; it is read only if edges[k] is kNeighbour.
struct PatchGeometry {
  std::array<Eigen::Vector2d, 3> corners;
  std::array<Eigen::Vector2d, 3> opposite;
  std::array<PatchEdge, 3> edges{};
};

// Fits a quadratic to a patch. D is the plate law, N m, Voigt (k11, k22, 2 k12); only its inverse is needed.
// Fit: P_r = phi(X_r) - sum_k lambda_k(X_r) phi(X_k) with phi(d) = (d1^2/2, d2^2/2, d1 d2/2) about corner 0 and
// barycentrics lambda; kappa = D^-1 P^T G^+ w, G = P D^-1 P^T, w_r = x_r - sum_k lambda_k x_k, so that kappa.D kappa =
// w.G^+ w. The pseudo-inverse G^+ cuts off eigenvalues below kEigenvalueCutOff of the largest: the fit is not unique if
// the six points lie on a conic.
// A clamped edge has a derivative in place of the vertex across: h times that of x along the outward normal nu in its
// middle M, with h the height of the triangle over it. P_r = h (phi_nu(M) - sum_k lambda_k,nu phi(X_k)), w_r = h x_nu -
// sum_k h lambda_k,nu x_k, and row 3 + r of Q is that of h x_nu. For many patches see bending_lanes.h.
inline constexpr double kEigenvalueCutOff = 0.001;  // -; below it the fit amplifies a near-conic's noise
BendingFit fit_bending(const PatchGeometry& patch, const Eigen::Matrix3d& D_inverse);

// Returns h nu of a clamped edge: m, material axes.
Eigen::Vector2d clamp_arm(const std::array<Eigen::Vector2d, 3>& corners, std::size_t edge);

}  // namespace kerf::fem
