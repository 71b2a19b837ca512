#include "server/fem/block_cholesky.h"

#include <algorithm>
#include <cmath>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

namespace kerf::fem {
namespace {

// Lower Cholesky factor of a symmetric 3x3 block; false where it is not positive definite.
bool factorise_block(const Eigen::Matrix3d& A, Eigen::Matrix3d& L) {
  L.setZero();
  for (int j = 0; j < 3; ++j) {
    double pivot = A(j, j);
    for (int k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    if (!(pivot > 0.0)) return false;
    L(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < 3; ++i) {
      double value = A(i, j);
      for (int k = 0; k < j; ++k) value -= L(i, k) * L(j, k);
      L(i, j) = value / L(j, j);
    }
  }
  return true;
}

// X := X L^-T.
void solve_right_transposed(const Eigen::Matrix3d& L, Eigen::Matrix3d& X) {
  X.col(0) = (X.col(0) / L(0, 0)).eval();
  X.col(1) = ((X.col(1) - L(1, 0) * X.col(0)) / L(1, 1)).eval();
  X.col(2) = ((X.col(2) - L(2, 0) * X.col(0) - L(2, 1) * X.col(1)) / L(2, 2)).eval();
}

}  // namespace

void BlockCholesky::analyse(const BlockMatrix& A) {
  order(A);
  analyse_factor(A);
  block_.assign(row_.size(), Eigen::Matrix3d::Zero());
  work_.assign(static_cast<std::size_t>(A.num_rows()), Eigen::Matrix3d::Zero());
  permuted_.resize(A.num_rows());
  residual_.resize(A.num_rows());
}

void BlockCholesky::order(const BlockMatrix& A) {
  const int n = A.num_rows();
  std::vector<Eigen::Triplet<double>> pattern;
  pattern.reserve(static_cast<std::size_t>(A.num_blocks()));
  for (int i = 0; i < n; ++i) {
    for (int at = A.row_begin(i); at < A.row_end(i); ++at) pattern.emplace_back(i, A.column(at), 1.0);
  }
  Eigen::SparseMatrix<double> graph(n, n);
  graph.setFromTriplets(pattern.begin(), pattern.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(graph, permutation);
  old_from_new_.assign(permutation.indices().begin(), permutation.indices().end());
  new_from_old_.resize(static_cast<std::size_t>(n));
  for (int j = 0; j < n; ++j) new_from_old_[static_cast<std::size_t>(old_from_new_[static_cast<std::size_t>(j)])] = j;
}

// Pattern of column j of L: rows of column j of A below the diagonal, and those of its children in the elimination
// tree.
void BlockCholesky::analyse_factor(const BlockMatrix& A) {
  const auto n = static_cast<std::size_t>(A.num_rows());
  std::vector<std::vector<int>> below(n);
  std::vector<std::vector<int>> children(n);
  std::vector<int> mark(n, -1);
  column_begin_.assign(1, 0);
  row_.clear();
  std::vector<int> row_count(n, 0);
  for (std::size_t j = 0; j < n; ++j) {
    const int column = static_cast<int>(j);
    std::vector<int>& rows = below[j];
    const auto add = [&](int i) {
      if (i <= column || mark[static_cast<std::size_t>(i)] == column) return;
      mark[static_cast<std::size_t>(i)] = column;
      rows.push_back(i);
    };
    const int old_column = old_from_new_[j];
    for (int at = A.row_begin(old_column); at < A.row_end(old_column); ++at) {
      add(new_from_old_[static_cast<std::size_t>(A.column(at))]);
    }
    for (const int child : children[j]) {
      for (const int i : below[static_cast<std::size_t>(child)]) add(i);
    }
    std::sort(rows.begin(), rows.end());
    if (!rows.empty()) children[static_cast<std::size_t>(rows.front())].push_back(column);
    row_.push_back(column);
    row_.insert(row_.end(), rows.begin(), rows.end());
    for (const int i : rows) ++row_count[static_cast<std::size_t>(i)];
    column_begin_.push_back(static_cast<int>(row_.size()));
  }
  left_begin_.assign(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) left_begin_[i + 1] = left_begin_[i] + row_count[i];
  left_.resize(static_cast<std::size_t>(left_begin_[n]));
  std::vector<int> next(left_begin_.begin(), left_begin_.end() - 1);
  for (std::size_t k = 0; k < n; ++k) {
    for (int at = column_begin_[k] + 1; at < column_begin_[k + 1]; ++at) {
      const auto i = static_cast<std::size_t>(row_[static_cast<std::size_t>(at)]);
      left_[static_cast<std::size_t>(next[i]++)] = {static_cast<int>(k), at};
    }
  }
}

bool BlockCholesky::factorise(const BlockMatrix& A) {
  const auto n = static_cast<std::size_t>(A.num_rows());
  for (std::size_t j = 0; j < n; ++j) {
    const int old_column = old_from_new_[j];
    for (int at = A.row_begin(old_column); at < A.row_end(old_column); ++at) {
      const auto i = static_cast<std::size_t>(new_from_old_[static_cast<std::size_t>(A.column(at))]);
      if (i >= j) work_[i] = A.block(at).transpose();  // block (i, j) of a symmetric matrix
    }
    for (int e = left_begin_[j]; e < left_begin_[j + 1]; ++e) {
      const RowEntry& entry = left_[static_cast<std::size_t>(e)];
      const Eigen::Matrix3d L_jk = block_[static_cast<std::size_t>(entry.position)];
      const int end = column_begin_[static_cast<std::size_t>(entry.column) + 1];
      for (int at = entry.position; at < end; ++at) {
        const auto p = static_cast<std::size_t>(at);
        work_[static_cast<std::size_t>(row_[p])].noalias() -= block_[p] * L_jk.transpose();
      }
    }
    const auto diagonal = static_cast<std::size_t>(column_begin_[j]);
    const bool positive = factorise_block(work_[j], block_[diagonal]);
    work_[j].setZero();
    for (std::size_t p = diagonal + 1; p < static_cast<std::size_t>(column_begin_[j + 1]); ++p) {
      Eigen::Matrix3d& work = work_[static_cast<std::size_t>(row_[p])];
      block_[p] = work;
      if (positive) solve_right_transposed(block_[diagonal], block_[p]);
      work.setZero();
    }
    if (!positive) return false;
  }
  return true;
}

void BlockCholesky::substitute(const mesh::VertexField& b, mesh::VertexField& x) {
  const int n = static_cast<int>(old_from_new_.size());
  for (int j = 0; j < n; ++j) permuted_.col(j) = b.col(old_from_new_[static_cast<std::size_t>(j)]);
  for (int j = 0; j < n; ++j) {
    const auto column = static_cast<std::size_t>(j);
    const auto diagonal = static_cast<std::size_t>(column_begin_[column]);
    const Eigen::Vector3d y = block_[diagonal].triangularView<Eigen::Lower>().solve(permuted_.col(j));
    permuted_.col(j) = y;
    for (std::size_t p = diagonal + 1; p < static_cast<std::size_t>(column_begin_[column + 1]); ++p) {
      permuted_.col(row_[p]).noalias() -= block_[p] * y;
    }
  }
  for (int j = n - 1; j >= 0; --j) {
    const auto column = static_cast<std::size_t>(j);
    const auto diagonal = static_cast<std::size_t>(column_begin_[column]);
    Eigen::Vector3d y = permuted_.col(j);
    for (std::size_t p = diagonal + 1; p < static_cast<std::size_t>(column_begin_[column + 1]); ++p) {
      y.noalias() -= block_[p].transpose() * permuted_.col(row_[p]);
    }
    permuted_.col(j) = block_[diagonal].transpose().triangularView<Eigen::Upper>().solve(y);
  }
  for (int j = 0; j < n; ++j) x.col(old_from_new_[static_cast<std::size_t>(j)]) = permuted_.col(j);
}

LinearStats BlockCholesky::solve(const BlockMatrix& A, const mesh::VertexField& b, double tolerance,
                                 mesh::VertexField& x) {
  LinearStats stats;
  if (!factorise(A)) return stats;
  substitute(b, x);
  stats.iterations = 1;
  A.multiply(x, residual_);
  residual_ -= b;
  const double b_norm = b.norm();
  stats.residual = b_norm > 0.0 ? residual_.norm() / b_norm : 0.0;
  stats.converged = stats.residual <= tolerance && x.allFinite();
  return stats;
}

}  // namespace kerf::fem
