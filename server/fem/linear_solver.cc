#include "server/fem/linear_solver.h"

#include "server/fem/block_cholesky.h"
#include "server/fem/conjugate_gradient.h"

namespace kerf::fem {

std::unique_ptr<LinearSolver> make_linear_solver(LinearSolverKind kind, int max_iterations) {
  if (kind == LinearSolverKind::kDirect) return std::make_unique<BlockCholesky>();
  return std::make_unique<ConjugateGradient>(max_iterations);
}

}  // namespace kerf::fem
