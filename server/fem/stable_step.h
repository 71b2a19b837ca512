#pragma once

#include <vector>

#include "server/fem/model.h"

namespace kerf::fem {

// Upper bound of the largest eigenvalue of M^-1 K at rest, 1/s^2, membrane and bending. Two parts, added:
//   Membrane: lambda_max(M^-1 K) <= max_e lambda_max(M_e^-1 K_e) for any split of the lumped masses among the triangles
//   around each vertex (Fried 1972, "Bounds on the extremal eigenvalues of the finite element stiffness and mass
//   matrices"). The mass is split in proportion to the triangles' stiffness at the vertex, so that a sliver borrows
//   mass from its neighbours; the eigenvalue of the 3x3 matrix H that remains is bounded by (tr H^8)^(1/8).
//   Bending: largest absolute row sum of M^-1/2 Q M^-1/2 (Gershgorin).
// The membrane part holds at rest; tension and folding raise it only moderately for the co-rotational law, which is
// what the safety factor of the explicit integrator (IntegratorOptions::cfl) is for.
double stiffness_bound(const Model& model);

}  // namespace kerf::fem
