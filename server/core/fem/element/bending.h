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
// Q is constant, positive semidefinite, and invariant under translation and rotation. Each neighbour adds one condition
// to the fit. An edge without a neighbour adds none, which is the natural boundary condition of a free edge.
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

// The fit of a patch. Row r of `conditions` belongs to the neighbour or the clamp at edge r, and is 0 if the edge is
// free. With w = conditions x the energy is E = 1/2 w.law w, hence Q = conditions^T law conditions.
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

// -, ratio to the largest eigenvalue, used by fit_bending(). Below it the fit amplifies the noise of six points that
// nearly lie on a conic.
inline constexpr double kEigenvalueCutOff = 0.001;

// Fits a quadratic to a patch. D is the plate law, N m, Voigt (k11, k22, 2 k12); only its inverse is needed. For many
// patches see bending_lanes.h.
//
// X_k and x_k are the corners at rest and now, X_r and x_r the vertex across edge r. lambda are barycentric coordinates
// in the triangle, and phi(d) = (d1^2/2, d2^2/2, d1 d2/2) with d measured from corner 0. Each edge gives the condition
//   w_r = x_r - sum_k lambda_k(X_r) x_k = P_r kappa,   P_r = phi(X_r) - sum_k lambda_k(X_r) phi(X_k).
// The curvature that obeys them with the least energy is
//   kappa = D^-1 P^T G^+ w,   G = P D^-1 P^T,   so that kappa.D kappa = w.G^+ w.
// The pseudo-inverse G^+ cuts off eigenvalues below kEigenvalueCutOff of the largest: the fit is not unique if the six
// points lie on a conic.
// A clamped edge has no vertex across it. Its condition holds h x_nu instead. x_nu is the derivative of x along the
// outward normal nu in the middle M of the edge, and h the height of the triangle over the edge:
//   w_r = h x_nu - sum_k h lambda_k,nu x_k,   P_r = h (phi_nu(M) - sum_k lambda_k,nu phi(X_k)).
// Row 3 + r of Q then belongs to h x_nu.
BendingFit fit_bending(const PatchGeometry& patch, const Eigen::Matrix3d& D_inverse);

// Returns h nu of a clamped edge, m, in material axes: its outward unit normal times the height of the triangle over
// it.
Eigen::Vector2d clamp_arm(const std::array<Eigen::Vector2d, 3>& corners, std::size_t edge);

}  // namespace kerf::fem
