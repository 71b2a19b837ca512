#include "server/core/linear/direct_solver.h"

#include <utility>

namespace kerf::linear {

void DirectSolver::analyse(const BlockMatrix& A) {
  factor_.analyse(A);
  residual_.resize(A.num_rows());
}

void DirectSolver::analyse(const BlockMatrix& A, std::shared_ptr<const Supernodes> supernodes) {
  factor_.analyse(A, std::move(supernodes));
  residual_.resize(A.num_rows());
}

LinearStats DirectSolver::solve(const BlockMatrix& A, const VertexField& b, double tolerance, VertexField& x) {
  LinearStats stats;
  PivotRule<double> rule;
  const bool is_factored = factor_.factorise(A, {}, rule);
  if (is_factored) factor_.solve(b, x);
  stats.iterations = is_factored ? 1 : 0;
  A.multiply(x, residual_);
  residual_ -= b;
  const double b_norm = b.norm();
  stats.residual = b_norm > 0.0 ? residual_.norm() / b_norm : 0.0;
  stats.converged = is_factored && stats.residual <= tolerance && x.allFinite();
  return stats;
}

}  // namespace kerf::linear
