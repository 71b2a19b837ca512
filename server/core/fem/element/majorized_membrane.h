#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/element_lanes.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// A convex quadratic q above the energy W of one co-rotational triangle (see membrane.h). It touches W at the current
// state F = R V: q >= W for every other F, and value and gradient are equal there.
//   q(F') / A = <F', F' H> - z <R, F'> + constant,   V H + H V = z I + sigma,   sigma = C (V - I) as a matrix,
//   gradient 2 F' H - z R,   second derivative 2 g_i.H g_j times the 3x3 identity for corners i, j.
// An implicit Euler step with q in place of W never ends with more kinetic and potential energy than it began with.
// This holds for any step, stiffness and state, because bending, dead loads and pins at rest are convex. With p the
// potential of that step and x1 - x0 = d v1,
//   K1 - K0 <= (x1 - x0).M (v1 - v0) / d = -(x1 - x0).grad p(x1) <= p(x0) - p(x1),  and  W <= q, W(x0) = q(x0).
// Conjugate gradients that start at x0 may stop anywhere: their residual is perpendicular to x1 - x0. If they restart
// on the way, as when a factor is refactored, they must converge.
//
// Proof of q >= W. R is the rotation that makes <R', F> largest, tr U, so that only U, F' = R' U, counts. Let Ca = C +
// B, with B positive semidefinite, be a law for which U.Ca U / 2 is concave as a function of X = F'^T F' = U^2. Then
//   W / A = U.Ca U / 2 - U.B U / 2 - (C I).U + constant.
// The first term is concave in X and the second in U, so each is below its tangent at V. The terms linear in U are then
// -Z.U with Z = C I + B V. They are split: -z tr U <= -z <R, F'>, and (z I - Z).U is concave in X if z is at least any
// eigenvalue of Z, since square roots of matrices are concave. Together the tangents are <H, X>. It remains to find B.
// In material axes
//   U.C U = C11 X11 + C22 X22 + 2 C12 sqrt(det X) + k X12^2 / (tr X + 2 sqrt(det X)),  k = 4 C33 + 2 C12 - C11 - C22.
// This is concave if C12 >= 0 and k <= 0: sqrt(det X) is concave, and y^2 / s is convex and falls as s grows. Hence
//   B = diag(a, a, 0) + b [1, 1, 0; 1, 1, 0; 0, 0, 0],   a = max(0, k) / 2,   b = max(0, -C12),
//   z = max(C11 + a V11, C22 + a V22) + C12 + b tr V.
// H is positive semidefinite, because U.Ca U and (z I - Z).U are concave in X and nowhere negative. For an isotropic
// law with nu >= 0, k = 0 and B = 0: q has -2 (mu + lambda) <R, F'> and lambda / 2 tr V <F', F' V^-1>, as is known for
// this material. In trials every smaller z put q below W somewhere. The bound for other orthotropic laws is Kerf's own.
// For them trials found room for a z smaller by a fifth. If the moduli of the two axes differ by 1e3 the room is up to
// a factor of 14.
//
// H grows without bound as a triangle collapses, so eigenvalues of V are kept above kLeastStretch. Then q is still
// above W, and touches it to within some kLeastStretch C max(1, V). Angular momentum is not conserved, because q pulls
// towards the R of the current state.
class MajorizedTriangle {
 public:
  static constexpr double kLeastStretch = 1e-6;  // -, least eigenvalue of V, also relative to the larger one

  // `frames` holds the frames of all lanes of the block at the current state.
  MajorizedTriangle(const ElementBlock& block, std::size_t lane, const LaneFrames& frames,
                    const MaterialTable& materials);

  // Returns the energy of the triangle with another deformation gradient, J.
  [[nodiscard]] double energy(const Eigen::Matrix<double, 3, 2>& F) const;
  // Returns the force on a corner at the current state, N.
  [[nodiscard]] Eigen::Vector3d force(int corner) const;
  // Returns the factor of the identity in the stiffness for corners i and j, N/m.
  [[nodiscard]] double stiffness(int i, int j) const { return 2.0 * area_ * g_.col(i).dot(H_ * g_.col(j)); }

 private:
  using Matrix32 = Eigen::Matrix<double, 3, 2>;

  double area_;
  Matrix32 R_;
  Matrix32 F_;
  Eigen::Matrix2d H_;  // N/m
  double z_ = 0.0;     // N/m
  double constant_ = 0.0;
  Eigen::Matrix<double, 2, 3> g_;  // column k: gradient of corner k, 1/m
};

// Adds to f (3 x V, N) the forces at x (3 x V, m) of the quadratics that touch the energy there. They equal the forces
// of the membrane, except for collapsed triangles.
void add_majorized_forces(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                          const linear::VertexField& x, linear::VertexField& f);

}  // namespace kerf::fem
