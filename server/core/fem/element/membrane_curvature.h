#pragma once

#include <Eigen/Core>

namespace kerf::fem {

// Second derivatives of the co-rotational energy of a triangle per area, W(F) = e.C e / 2 with e = U - I, F = R U (see
// membrane.h), as a function of all six components of F.

// Returns the largest second derivative of W, N/m: max over G of the quadratic form W''(F)[G, G] / |G|^2. F = U has
// principal stretches `stretch`, > 0, the first at `angle`, rad, to material axis 1.
//   With principal axes for coordinates, and G = [A; n], A in the plane and n across it: dU_ij = (u_i A_ij + u_j A_ji)
//     / (u_i + u_j),   d2U_ij = 2 (A^T A + n n^T - dU dU)_ij / (u_i + u_j), W'' = dU.C dU + sigma : d2U,   sigma = C (U
//     - I).
double membrane_curvature(const Eigen::Matrix3d& C, const Eigen::Vector2d& stretch, double angle);

// Returns z, N/m: W'' <= z |G|^2 if no principal stretch is above kMostStretch and at least one is above kLeastStretch.
// Then z A g_i.g_j times the 3x3 identity bounds the stiffness of a triangle that is turned, folded or compressed. For
// an isotropic law with nu >= 0 it is 2 (mu + lambda), for every F with tr U - 2 <= 2 mu / lambda. There
//     W = mu |U - I|^2 + lambda / 2 (tr U - 2)^2,   W'' = 2 mu + lambda R(x)R + (lambda (tr U - 2) - 2 mu) d2 tr U,
// d2 tr U >= 0 as the sum of singular values is convex, and |R|^2 = 2. For other laws it is the largest
// membrane_curvature over a net of stretches and angles, plus a margin.
double membrane_curvature_bound(const Eigen::Matrix3d& C);
inline constexpr double kLeastStretch = 0.25;
inline constexpr double kMostStretch = 1.25;

}  // namespace kerf::fem
