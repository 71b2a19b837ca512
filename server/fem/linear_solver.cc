#include "server/fem/linear_solver.h"

#include "server/fem/conjugate_gradient.h"
#include "server/fem/covariance_root_solver.h"
#include "server/fem/direct_solver.h"

namespace kerf::fem {

std::unique_ptr<LinearSolver> make_linear_solver(LinearSolverKind kind, int max_iterations,
                                                 const CovarianceRootOptions& root) {
  switch (kind) {
    case LinearSolverKind::kPlainCg:
      return std::make_unique<ConjugateGradient>(Preconditioner::kNone, max_iterations);
    case LinearSolverKind::kJacobiCg:
      return std::make_unique<ConjugateGradient>(Preconditioner::kJacobi, max_iterations);
    case LinearSolverKind::kDirect:
      return std::make_unique<DirectSolver>();
    case LinearSolverKind::kEsCgm:
    case LinearSolverKind::kAsCgm:
      return std::make_unique<CovarianceRootSolver>(kind, root, max_iterations);
