#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Bending stiffness of one triangle, from a quadratic fitted through its corners and the opposite corners of its up to
// three neighbours. For a flat rest shape the curvature is linear in the positions, kappa = B x, so that the energy is
//   E = A/2 sum over x,y,z of kappa.D kappa = 1/2 x.Q x,   Q = A B^T D B  (times the 3x3 identity):
// constant, positive semidefinite, invariant under translation and rotation. A missing neighbour just leaves out its
// condition, the natural condition of a free edge.
struct BendingPatch {
  // 0..2 corners, 3 + k the vertex across the edge opposite corner k, kNone where there is none.
  std::array<mesh::VertexId, 6> vertex{mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone};
  // Upper triangle of Q by rows, N/m; zero in rows and columns of missing vertices, but for those of clamped edges.
  std::array<double, 21> stiffness{};

  [[nodiscard]] double at(int a, int b) const { return stiffness[kPlace[static_cast<std::size_t>(6 * a + b)]]; }

  // Of entry (a, b), at 6 a + b, in an upper triangle by rows.
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

// The fit of a patch: w = conditions x, of which a missing neighbour's row is 0, and E = 1/2 w.law w, so that
// Q = conditions^T law conditions.
struct BendingFit {
  Eigen::Matrix<double, 3, 6> conditions = Eigen::Matrix<double, 3, 6>::Zero();  // -
  Eigen::Matrix3d law = Eigen::Matrix3d::Zero();                                 // N/m
};

// What is across an edge of a triangle: nothing, another triangle, or a clamp, which holds the slope of the sheet
// across a border edge.
enum class PatchEdge : std::uint8_t { kFree, kNeighbour, kClamped };

// corners: rest positions of the triangle, m, material axes, counter-clockwise. opposite[k]: of the vertex across the
// edge opposite corner k; read only where edges[k] is kNeighbour.
struct PatchGeometry {
  std::array<Eigen::Vector2d, 3> corners;
  std::array<Eigen::Vector2d, 3> opposite;
  std::array<PatchEdge, 3> edges{};
};

// D: plate law, N m, Voigt (k11, k22, 2 k12); its inverse is enough. Fit: P_r = phi(X_r) - sum_k lambda_k(X_r) phi(X_k)
// with phi(d) = (d1^2/2, d2^2/2, d1 d2/2) about corner 0 and barycentrics lambda; kappa = D^-1 P^T G^+ w,
// G = P D^-1 P^T, w_r = x_r - sum_k lambda_k x_k, so that kappa.D kappa = w.G^+ w. Eigenvalues below kEigenvalueCutOff
// of the largest are cut from the pseudo-inverse G^+: the six points may lie on a conic, where the fit is not unique.
// At a clamped edge the derivative of x along the outward normal nu in its middle M, times the height h of the triangle
// over it, takes the place of the vertex across: P_r = h (phi_nu(M) - sum_k lambda_k,nu phi(X_k)), w_r = h x_nu - sum_k
// h lambda_k,nu x_k, and row 3 + r of Q is that of h x_nu. For many patches see bending_lanes.h.
inline constexpr double kEigenvalueCutOff = 0.001;  // -; below it the fit amplifies a near-conic's noise
BendingFit fit_bending(const PatchGeometry& patch, const Eigen::Matrix3d& D_inverse);

// h nu of a clamped edge: m, material axes.
Eigen::Vector2d clamp_arm(const std::array<Eigen::Vector2d, 3>& corners, std::size_t edge);

}  // namespace kerf::fem
