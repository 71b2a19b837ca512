#include "server/core/linear/covariance_root_solver.h"

namespace kerf::linear {

void CovarianceRootSolver::analyse(const BlockMatrix& A) {
  root_.resize(A.num_rows(), kind_);
  solver_.analyse(A);
  residual_.resize(A.num_rows());
}

LinearStats CovarianceRootSolver::solve(const BlockMatrix& A, const VertexField& b, double tolerance, VertexField& x) {
  const Eigen::MatrixXd& substitute = kind_ == LinearSolverKind::kEsCgm ? root_.exact(A) : root_.approximate(A);
  LinearStats stats;
  if (substitute.allFinite()) stats = solver_.solve(substitute, b, tolerance, x);
  A.multiply(x, residual_);
  residual_ = b - residual_;
  const double b_norm = b.norm();
  stats.residual = b_norm > 0.0 ? residual_.norm() / b_norm : 0.0;
  stats.converged = stats.residual <= tolerance;
  return stats;
}

}  // namespace kerf::linear
