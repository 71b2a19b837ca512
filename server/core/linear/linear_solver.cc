#include "server/core/linear/linear_solver.h"

#include <algorithm>
#include <utility>

#include "server/core/linear/conjugate_gradient.h"
#include "server/core/linear/covariance_root_solver.h"
#include "server/core/linear/direct_solver.h"
#include "server/core/linear/factor_preconditioner.h"
#include "server/core/linear/multigrid_preconditioner.h"
#include "server/core/linear/preconditioner.h"

namespace kerf::linear {
namespace {

// Most iterations of kFactorCg, first with an old factor and then with a new one. If a solve needs more, the float
// factor is too inaccurate for the matrix.
constexpr int kMostFactorIterations = 2 * FactorPreconditioner::kMaxReuseIterations;

// Conjugate gradients with the float factor; the direct solver takes over if they do not converge.
class FactorCgSolver final : public LinearSolver {
 public:
  explicit FactorCgSolver(int max_iterations)
      : FactorCgSolver(std::make_unique<FactorPreconditioner>(), max_iterations) {}

  void analyse(const BlockMatrix& A) override {
    gradients_.analyse(A);
    direct_.analyse(A, factor_.supernodes());
  }
  LinearStats solve(const BlockMatrix& A, const VertexField& b, double tolerance, VertexField& x) override {
    const LinearStats by_gradients = gradients_.solve(A, b, tolerance, x);
    if (by_gradients.converged) return by_gradients;
    LinearStats by_factor = direct_.solve(A, b, tolerance, x);
    by_factor.iterations += by_gradients.iterations;
    return by_factor;
  }
  void reset() override { gradients_.reset(); }
  void set_stop_condition(const StopCondition* stop) override {
    gradients_.set_stop_condition(stop);
    direct_.set_stop_condition(stop);
  }
  std::vector<Eigen::Matrix3d>* frames() override { return gradients_.frames(); }

 private:
  FactorCgSolver(std::unique_ptr<FactorPreconditioner> factor, int max_iterations)
      : factor_(*factor), gradients_(std::move(factor), max_iterations) {}

  const FactorPreconditioner& factor_;  // the preconditioner of gradients_
  ConjugateGradient gradients_;
  DirectSolver direct_;
};

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
      return std::make_unique<FactorCgSolver>(std::min(max_iterations, kMostFactorIterations));
    case LinearSolverKind::kMultigridCg:
      return std::make_unique<ConjugateGradient>(std::make_unique<MultigridPreconditioner>(), max_iterations);
    default:
      return std::make_unique<ConjugateGradient>(make_diagonal(kind), max_iterations);
  }
}

}  // namespace kerf::linear
