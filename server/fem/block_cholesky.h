#pragma once

#include <vector>

#include "server/fem/linear_solver.h"
#include "server/mesh/vertex_field.h"

namespace kerf::fem {

// Direct solver: L L^T = P A P^T in 3x3 blocks, left-looking (Davis 2006, Direct Methods for Sparse Linear Systems, ch.
// 4), P a minimum-degree order of the vertices. Each solve factorises anew; the factor's pattern comes from analyse(),
// so no solve allocates.
class BlockCholesky final : public LinearSolver {
 public:
  void analyse(const BlockMatrix& A) override;
  LinearStats solve(const BlockMatrix& A, const mesh::VertexField& b, double tolerance, mesh::VertexField& x) override;
  // With the matrix of the last solve(), which must have found it positive definite.
  void solve_again(const mesh::VertexField& b, mesh::VertexField& x) { substitute(b, x); }

 private:
  // Block L_jk, k < j, as the columns to its left are gone through for column j.
  struct RowEntry {
    int column = 0;    // k
    int position = 0;  // of L_jk in row_ and block_
  };

  void order(const BlockMatrix& A);
  void analyse_factor(const BlockMatrix& A);
  bool factorise(const BlockMatrix& A);  // false: not positive definite
  void substitute(const mesh::VertexField& b, mesh::VertexField& x);

  std::vector<int> new_from_old_, old_from_new_;
  std::vector<int> column_begin_;  // positions of column j: its diagonal first, then rows ascending
  std::vector<int> row_;
  std::vector<Eigen::Matrix3d> block_;
  std::vector<int> left_begin_;  // entries of row j of L left of the diagonal
  std::vector<RowEntry> left_;
  std::vector<Eigen::Matrix3d> work_;  // one block a row, zero between columns
  mesh::VertexField permuted_, residual_;
};

}  // namespace kerf::fem
