#pragma once

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::bench {

// Largest over smallest eigenvalue of D^-1/2 A D^-1/2, D = diag(A), where A is the scalar Laplacian of the opened mesh
// in rest space (linear elements) plus its lumped mass / (1 m / pi)^2: what Jacobi-preconditioned conjugate gradients
// see of the shapes of the triangles. The mass keeps A definite for loose pieces. To 4 digits or so.
double condition_number(const mesh::TriangleMesh& mesh);

}  // namespace kerf::bench
