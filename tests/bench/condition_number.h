#pragma once

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::bench {

// Returns the largest over the smallest eigenvalue of D^-1/2 A D^-1/2, D = diag(A), to 4 digits or so. A is the scalar
// Laplacian of the opened mesh in rest space (linear elements) plus its lumped mass / (1 m / pi)^2. The mass keeps A
// definite for loose pieces. Conjugate gradients preconditioned by Jacobi see this much of the triangles' shapes.
double condition_number(const mesh::TriangleMesh& mesh);

}  // namespace kerf::bench
