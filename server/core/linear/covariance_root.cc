#include "server/core/linear/covariance_root.h"

#include <algorithm>
#include <cmath>

#include "server/base/check.h"
#include "server/base/elementary.h"

namespace kerf::linear {
namespace {

constexpr double kRegularisation = 1e-6;  // epsilon I, added to D

// Products are computed tile by tile, because Eigen packs operands of this size on the stack and allocates memory for
// larger ones.
constexpr Eigen::Index kTile = 64;
using Tile = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kTile, kTile>;
using Block = Eigen::Ref<Eigen::MatrixXd>;
using ConstBlock = Eigen::Ref<const Eigen::MatrixXd>;

// Calls f(begin, size) for each tile of 0 .. n.
template <typename Function>
void for_tiles(Eigen::Index n, const Function& f) {
  for (Eigen::Index begin = 0; begin < n; begin += kTile) f(begin, std::min(kTile, n - begin));
}

// Computes C = A B. C must not share memory with A or B.
void multiply(const ConstBlock& A, const ConstBlock& B, Block C) {
  C.setZero();
  for_tiles(B.cols(), [&](Eigen::Index j, Eigen::Index columns) {
    for_tiles(A.cols(), [&](Eigen::Index k, Eigen::Index depth) {
      for_tiles(A.rows(), [&](Eigen::Index i, Eigen::Index rows) {
        C.block(i, j, rows, columns).noalias() += A.block(i, k, rows, depth) * B.block(k, j, depth, columns);
      });
    });
  });
}

// Returns a tile of diag(d) L^T: its columns are rows of L from `row` on, its rows are columns of L from `column` on.
Tile scaled_transpose(const Eigen::MatrixXd& L, const Eigen::VectorXd& d, Eigen::Index row, Eigen::Index rows,
                      Eigen::Index column, Eigen::Index columns) {
  Tile tile(columns, rows);
  for (Eigen::Index j = 0; j < rows; ++j) {
    for (Eigen::Index i = 0; i < columns; ++i) tile(i, j) = d[column + i] * L(row + j, column + i);
  }
  return tile;
}

// Sets M to the covariance of the rows of A; `mean` is scratch.
void covariance(const BlockMatrix& A, Eigen::MatrixXd& M, Eigen::VectorXd& mean) {
  M.setZero();
  mean.setZero();
  // Computes sum a^T a - n mean^T mean, the expanded square, because rows are sparse and their mean is not.
  for (int row = 0; row < A.num_rows(); ++row) {
    for (int i = A.row_begin(row); i < A.row_end(row); ++i) {
      const Eigen::Index at = 3 * A.column(i);
      mean.segment<3>(at) += A.block(i).colwise().sum().transpose();
      for (int j = A.row_begin(row); j < A.row_end(row); ++j) {
        M.block<3, 3>(at, 3 * A.column(j)) += A.block(i).transpose() * A.block(j);
      }
    }
  }
  const auto n = static_cast<double>(M.rows());
  mean /= n;
  for (Eigen::Index j = 0; j < M.cols(); ++j) M.col(j) = (M.col(j) - n * mean[j] * mean) / (n - 1.0);
}

// Factors M = L D L^T in place, panel by panel: L with its unit diagonal below, 0 above. `column` is scratch.
void factorise(Eigen::MatrixXd& M, Eigen::VectorXd& D, Eigen::VectorXd& column) {
  const Eigen::Index n = M.rows();
  for_tiles(n, [&](Eigen::Index begin, Eigen::Index width) {
    for_tiles(begin, [&](Eigen::Index k, Eigen::Index depth) {
      const Tile right = scaled_transpose(M, D, begin, width, k, depth);
      for (Eigen::Index i = begin; i < n; i += kTile) {
        const Eigen::Index rows = std::min(kTile, n - i);
        M.block(i, begin, rows, width).noalias() -= M.block(i, k, rows, depth) * right;
      }
    });
    for (Eigen::Index j = begin; j < begin + width; ++j) {
      D[j] = M(j, j);
      column.segment(j, n - j) = M.col(j).segment(j, n - j);
      M.col(j).segment(j, n - j) /= D[j];
      for (Eigen::Index k = j + 1; k < begin + width; ++k) {
        M.col(k).segment(k, n - k) -= M(k, j) * column.segment(k, n - k);
      }
    }
  });
  for (Eigen::Index j = 0; j < n; ++j) {
    M.col(j).head(j).setZero();
    M(j, j) = 1.0;
  }
}

}  // namespace

void CovarianceRoot::resize(int num_rows, LinearSolverKind kind) {
  KERF_CHECK(num_rows <= kMaxCovarianceVertices, "a sheet that dense matrices are made for");
  const Eigen::Index n = 3 * Eigen::Index{num_rows};
  M_.resize(n, n);
  root_.resize(n, n);
  row_.resize(n);
  if (kind == LinearSolverKind::kEsCgm) {
    D_.resize(n);
  } else {
    Q_.resize(n, n);
    T_.resize(n, n);
  }
}

const Eigen::MatrixXd& CovarianceRoot::exact(const BlockMatrix& A) {
  covariance(A, M_, row_);
  factorise(M_, D_, row_);
  D_.array() += kRegularisation;
  if (options_.norm == EigenvalueNorm::kLog) {
    for (double& value : D_) value = decimal_logarithm(value);
  } else {
    for (double& value : D_) value = power(value, options_.power);
  }
  root_.setZero();
  const Eigen::Index n = M_.rows();
  for_tiles(n, [&](Eigen::Index j, Eigen::Index columns) {
    for_tiles(j + columns, [&](Eigen::Index k, Eigen::Index depth) {
      const Tile right = scaled_transpose(M_, D_, j, columns, k, depth);
      for (Eigen::Index i = j; i < n; i += kTile) {
        const Eigen::Index rows = std::min(kTile, n - i);
        root_.block(i, j, rows, columns).noalias() += M_.block(i, k, rows, depth) * right;
      }
    });
  });
  for (Eigen::Index j = 0; j < n; ++j) root_.col(j).head(j) = root_.row(j).head(j).transpose();
  return root_;
}

const Eigen::MatrixXd& CovarianceRoot::approximate(const BlockMatrix& A) {
  covariance(A, root_, row_);
  Q_.setIdentity();
  for (int k = 0; k < options_.newton_schulz_iterations && root_.allFinite(); ++k) {
    multiply(Q_, root_, T_);
    T_ *= -0.5;
    T_.diagonal().array() += 1.5;
    multiply(root_, T_, M_);
    root_.swap(M_);
    multiply(T_, Q_, M_);
    Q_.swap(M_);
  }
  return root_;
}

}  // namespace kerf::linear
