#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/element_lanes.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// A convex quadratic over the energy W of one co-rotational triangle (see membrane.h) that touches it where the
// triangle is: with F = R V there, q >= W for every other F, and value and gradient are the same at this one.
//   q(F') / A = <F', F' H> - z <R, F'> + constant,   V H + H V = z I + sigma,   sigma = C (V - I) as a matrix,
//   gradient 2 F' H - z R,   second derivative 2 g_i.H g_j times the 3x3 identity for corners i, j.
// A step of implicit Euler with q in place of W, bending, dead loads and pins at rest being convex as they are, never
// ends with more kinetic and potential energy than it began with, whatever step, stiffness and state: with p the
// potential of that step and x1 - x0 = d v1,
//   K1 - K0 <= (x1 - x0).M (v1 - v0) / d = -(x1 - x0).grad p(x1) <= p(x0) - p(x1),  and  W <= q, W(x0) = q(x0).
// Conjugate gradients that begin at x0 may stop anywhere: their residual is perpendicular to x1 - x0. (Those that begin
// anew on the way, as with a factor that is renewed, must end.)
//
// Why q >= W. R is the rotation that makes <R', F> largest, tr U, so that only U, F' = R' U, counts. Let Ca = C + B, B
// positive semidefinite, be a law for which U.Ca U / 2 is concave as a function of X = F'^T F' = U^2. Then
//   W / A = U.Ca U / 2 - U.B U / 2 - (C I).U + constant,
// the first concave in X, the second in U, so that each is below its tangent at V; of what is then linear in U, -Z.U
// with Z = C I + B V, -z tr U <= -z <R, F'>, and (z I - Z).U is concave in X where z is no less than any eigenvalue of
// Z, square roots of matrices being concave. Together the tangents are <H, X>. What is left is B. In material axes
//   U.C U = C11 X11 + C22 X22 + 2 C12 sqrt(det X) + k X12^2 / (tr X + 2 sqrt(det X)),  k = 4 C33 + 2 C12 - C11 - C22,
// concave where C12 >= 0 and k <= 0: sqrt(det X) is, and y^2 / s is convex, and falls where s grows. Hence
//   B = diag(a, a, 0) + b [1, 1, 0; 1, 1, 0; 0, 0, 0],   a = max(0, k) / 2,   b = max(0, -C12),
//   z = max(C11 + a V11, C22 + a V22) + C12 + b tr V.
// H is positive semidefinite, U.Ca U and (z I - Z).U being concave in X and nowhere negative. Of an isotropic law with
// nu >= 0, k = 0 and B = 0: q has -2 (mu + lambda) <R, F'> and lambda / 2 tr V <F', F' V^-1>, as is known of this
// material, and in trials no smaller z was above W. That for any orthotropic law is Kerf's own; there trials found room
// for a z smaller by a fifth, and by a factor of up to 14 where the axes differ by 1e3.
//
// H grows without bound where a triangle collapses: eigenvalues of V are kept above kLeastStretch. Then q is still
// above W, and touches it to within some kLeastStretch C max(1, V). Angular momentum is not kept: R does not turn.
class MajorizedTriangle {
 public:
  static constexpr double kLeastStretch = 1e-6;  // -, of an eigenvalue of V, and of the larger one

  // x relative: frames of the lane's triangle.
  MajorizedTriangle(const ElementBlock& block, std::size_t lane, const LaneFrames& frames,
                    const MaterialTable& materials);

  // J, of the triangle with another deformation gradient.
  [[nodiscard]] double energy(const Eigen::Matrix<double, 3, 2>& F) const;
  // N, on a corner, as the triangle is.
  [[nodiscard]] Eigen::Vector3d force(int corner) const;
  // N/m, of the identity, for corners i and j.
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

// f (3 x V, N) += forces at x (3 x V, m), where the quadratics touch: those of the membrane, but for collapsed
// triangles.
void add_majorized_forces(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                          const mesh::VertexField& x, mesh::VertexField& f);

}  // namespace kerf::fem
