#pragma once

#include "server/core/linear/block_matrix.h"
#include "server/core/linear/direct_solver.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Solves (A + N) x = b where A is symmetric positive definite and N skew, by the generalised conjugate gradients of
// Concus and Golub (1976) and Widlund (1978), "A Lanczos method for a class of nonsymmetric systems of linear
// equations": a short recurrence with A as preconditioner, in few iterations where N is small or of low rank.
class SkewCorrection {
 public:
  // `solver` has solved with A last, b and x (3 x V) being that right-hand side and that solution, where it starts.
  // Converged when |b - (A + N) x| <= tolerance |b|. Where it is not, x is the best that was found.
  LinearStats solve(DirectSolver& solver, const BlockMatrix& A, const BlockMatrix& N, const mesh::VertexField& b,
                    double tolerance, mesh::VertexField& x);

 private:
  mesh::VertexField current_, previous_, residual_, step_, product_;  // 3 x V
};

}  // namespace kerf::fem
