#pragma once

#include "server/core/linear/block_matrix.h"
#include "server/core/linear/direct_solver.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::linear {

// Solves (A + N) x = b where A is symmetric positive definite and N skew, by generalised conjugate gradients with A as
// preconditioner. References: Concus and Golub (1976); Widlund (1978), "A Lanczos method for a class of nonsymmetric
// systems of linear equations". The recurrence is short, and takes few iterations if N is small or of low rank.
class SkewCorrection {
 public:
  // Refines x. `solver` must have solved A x = b last, with these b and x (3 x V); x is the initial guess. The solve
  // has converged when |b - (A + N) x| <= tolerance |b|. x becomes the iterate with the least residual.
  LinearStats solve(DirectSolver& solver, const BlockMatrix& A, const BlockMatrix& N, const VertexField& b,
                    double tolerance, VertexField& x);

 private:
  VertexField current_, previous_, residual_, step_, product_;  // 3 x V
};

}  // namespace kerf::linear
