#pragma once

#include <Eigen/Core>

#include "server/core/linear/block_matrix.h"
#include "server/core/linear/linear_solver_kind.h"

namespace kerf::fem {

// Dense matrices that the solvers ES-CGM and AS-CGM put in place of the stiffness matrix A, step by step as published
// (the thesis named in the README, section 3.5). They are not A and no preconditioners of it: A' x = b has another
// solution than A x = b, so that a solver of these *solves a different system*. They are here to be compared.
//
// Both begin with the covariance of the rows of A, n x n (n = 3 N; units of A squared), eq. 3.21:
//   M = 1 / (n - 1) sum_i (a_i - mean)^T (a_i - mean),  a_i row i of A.
// Centred, it is singular. What follows mixes units: with masses in grams A' is another matrix in kind, not in scale.
class CovarianceRoot {
 public:
  explicit CovarianceRoot(const CovarianceRootOptions& options) : options_(options) {}

  // Memory for matrices of that many rows of blocks, at most kMaxCovarianceVertices, for one of the two; the only call
  // that allocates.
  void resize(int num_rows, LinearSolverKind kind);

  // ES-CGM: A' = L F(D + 1e-6 I) L^T where M = L D L^T without exchanging rows (eq. 3.22 to 3.25). D is not of
  // eigenvalues, though the thesis calls it so, and A' no square root of M. Not finite where a pivot is below -1e-6 or
  // 0, which rounding can lead to.
  const Eigen::MatrixXd& exact(const BlockMatrix& A);
  // AS-CGM: the coupled Newton-Schulz iteration (eq. 3.27) from P = M, Q = I; A' is the last P, Q being dropped. It
  // converges to M^1/2 only where |M - I| < 1, and M is not scaled to that; elsewhere it diverges, and ends early where
  // it is not finite any more.
  const Eigen::MatrixXd& approximate(const BlockMatrix& A);

 private:
  CovarianceRootOptions options_;
  Eigen::MatrixXd M_;        // n x n: M, then L, or room for the next P or Q
  Eigen::MatrixXd root_;     // n x n: A'
  Eigen::MatrixXd Q_, T_;    // n x n, AS-CGM alone
  Eigen::VectorXd D_, row_;  // n
};

}  // namespace kerf::fem
