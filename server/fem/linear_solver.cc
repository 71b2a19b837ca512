#include "server/fem/linear_solver.h"

#include <algorithm>

#include "server/fem/conjugate_gradient.h"
#include "server/fem/covariance_root_solver.h"
#include "server/fem/direct_solver.h"
#include "server/fem/preconditioner.h"

namespace kerf::fem {
namespace {

// A factor that needs more iterations has lost the matrix to rounding; each takes as long as a hundred plain ones.
constexpr int kMostFactorIterations = 100;

std::unique_ptr<Preconditioner> make_diagonal(LinearSolverKind kind) {
  switch (kind) {
    case LinearSolverKind::kPlainCg:
      return make_diagonal_preconditioner(Diagonal::kOnes);
    case LinearSolverKind::kJacobiCg:
      return make_diagonal_preconditioner(Diagonal::kEntries);
    default:
      return make_diagonal_preconditioner(Diagonal::kBlocks);
  }
}

}  // namespace

std::unique_ptr<LinearSolver> make_linear_solver(LinearSolverKind kind, int max_iterations,
                                                 const CovarianceRootOptions& root) {
  switch (kind) {
    case LinearSolverKind::kDirect:
      return std::make_unique<DirectSolver>();
    case LinearSolverKind::kEsCgm:
    case LinearSolverKind::kAsCgm:
      return std::make_unique<CovarianceRootSolver>(kind, root, max_iterations);
    case LinearSolverKind::kFactorCg:
      return std::make_unique<ConjugateGradient>(make_factor_preconditioner(),
                                                 std::min(max_iterations, kMostFactorIterations));
    default:
      return std::make_unique<ConjugateGradient>(make_diagonal(kind), max_iterations);
  }
}

}  // namespace kerf::fem
