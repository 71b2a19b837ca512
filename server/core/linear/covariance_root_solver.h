#pragma once

#include "server/core/linear/conjugate_gradient.h"
#include "server/core/linear/covariance_root.h"
#include "server/core/linear/linear_solver.h"

namespace kerf::linear {

// ES-CGM and AS-CGM: plain conjugate gradients on A' x = b, with A' of CovarianceRoot. *Solves a different system*: the
// result is no solution of A x = b. The statistics show that: residual and convergence are those of A x = b, the
// iterations those of A' x = b. If A' is not finite, x stays the initial guess.
class CovarianceRootSolver final : public LinearSolver {
 public:
  // `kind` is kEsCgm or kAsCgm.
  CovarianceRootSolver(LinearSolverKind kind, const CovarianceRootOptions& options, int max_iterations)
      : kind_(kind), root_(options), solver_(make_diagonal_preconditioner(Diagonal::kOnes), max_iterations) {}

  // A has at most kMaxCovarianceVertices rows.
  void analyse(const BlockMatrix& A) override;
  LinearStats solve(const BlockMatrix& A, const VertexField& b, double tolerance, VertexField& x) override;
  void set_stop_condition(const StopCondition* stop) override { solver_.set_stop_condition(stop); }

 private:
  LinearSolverKind kind_;
  CovarianceRoot root_;
  ConjugateGradient solver_;
  VertexField residual_;  // 3 x N
};

}  // namespace kerf::linear
