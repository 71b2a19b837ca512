#pragma once

#include <Eigen/Core>

#include "server/core/linear/block_matrix.h"
#include "server/core/linear/linear_solver_kind.h"

namespace kerf::linear {

// Dense matrices that the solvers ES-CGM and AS-CGM put in place of the stiffness matrix A. They follow section 3.5 of
// the thesis that server/README.md compares with, step by step. They are neither A nor preconditioners of it. A' x =
// b has another solution than A x = b, so these solvers *solve a different system*. They are here to be compared.
//
// Both begin with the covariance of the rows of A, n x n (n = 3 N; units of A squared), eq. 3.21:
//   M = 1 / (n - 1) sum_i (a_i - mean)^T (a_i - mean),  a_i row i of A.
// M is singular because it is centred. The steps after it mix units: with masses in grams A' is another matrix in kind,
// not in scale.
class CovarianceRoot {
 public:
  explicit CovarianceRoot(const CovarianceRootOptions& options) : options_(options) {}

  // Allocates matrices of `num_rows` block rows, at most kMaxCovarianceVertices, for one of the two solvers. No other
  // call allocates.
  void resize(int num_rows, LinearSolverKind kind);

  // ES-CGM: A' = L F(D + 1e-6 I) L^T where M = L D L^T without exchanging rows (eq. 3.22 to 3.25). F is the function
  // that CovarianceRootOptions::norm selects. D does not hold eigenvalues, though the thesis calls it so, and A' is no
  // square root of M. A' is not finite if a pivot is 0 or below -1e-6, which rounding can cause.
  const Eigen::MatrixXd& exact(const BlockMatrix& A);
  // AS-CGM: the coupled Newton-Schulz iteration (eq. 3.27) from P = M, Q = I. A' is the last P; Q is dropped. It
  // converges to M^1/2 only if |M - I| < 1, and M is not scaled to satisfy this. For other M it diverges, and ends
  // early once P is not finite.
  const Eigen::MatrixXd& approximate(const BlockMatrix& A);

 private:
  CovarianceRootOptions options_;
  Eigen::MatrixXd M_;        // n x n: M, then L (ES-CGM), or storage for the next P or Q (AS-CGM)
  Eigen::MatrixXd root_;     // n x n: A'
  Eigen::MatrixXd Q_, T_;    // n x n, AS-CGM only
  Eigen::VectorXd D_, row_;  // n
};

}  // namespace kerf::linear
