#pragma once

#include <memory>

#include "server/core/linear/linear_solver.h"
#include "server/core/linear/supernodal_cholesky.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::linear {

// Direct solver: a Cholesky factor in double precision, computed for every solve.
class DirectSolver final : public LinearSolver {
 public:
  void analyse(const BlockMatrix& A) override;
  // Reuses `supernodes`, the symbolic factorisation that another factor has computed for the same pattern.
  void analyse(const BlockMatrix& A, std::shared_ptr<const Supernodes> supernodes);
  LinearStats solve(const BlockMatrix& A, const VertexField& b, double tolerance, VertexField& x) override;
  void set_stop_condition(const StopCondition* stop) override { factor_.set_stop_condition(stop); }
  // Solves with the matrix of the last solve(), which must have found it positive definite.
  void solve_again(const VertexField& b, VertexField& x) { factor_.solve(b, x); }

 private:
  SupernodalCholesky<double> factor_;
  VertexField residual_;  // 3 x N
};

}  // namespace kerf::linear
