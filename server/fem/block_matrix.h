#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

namespace kerf::fem {

// Square sparse matrix of 3x3 blocks in compressed rows with a fixed pattern: columns ascending within a row, diagonal
// always present. Symmetric by use: both triangles are stored, so that a product reads memory in order.
class BlockMatrix {
 public:
  // columns[i]: the columns of row i, ascending, i among them. All blocks become zero.
  void set_pattern(const std::vector<std::vector<int>>& columns);

  [[nodiscard]] int num_rows() const { return static_cast<int>(row_begin_.size()) - 1; }
  [[nodiscard]] int num_blocks() const { return static_cast<int>(column_.size()); }

  // Blocks of row i are those at positions [row_begin(i), row_begin(i + 1)).
  [[nodiscard]] int row_begin(int i) const { return row_begin_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int column(int position) const { return column_[static_cast<std::size_t>(position)]; }
  [[nodiscard]] int diagonal(int i) const { return diagonal_[static_cast<std::size_t>(i)]; }
  // Position of block (i, j), or -1 where the pattern has none. Binary search.
  [[nodiscard]] int find(int i, int j) const;

  [[nodiscard]] Eigen::Matrix3d& block(int position) { return block_[static_cast<std::size_t>(position)]; }
  [[nodiscard]] const Eigen::Matrix3d& block(int position) const { return block_[static_cast<std::size_t>(position)]; }

  void set_zero();
  // y = A x; x, y: 3 x N, y must not alias x.
  void multiply(const Eigen::Matrix3Xd& x, Eigen::Matrix3Xd& y) const;

 private:
  std::vector<int> row_begin_{0};
  std::vector<int> column_;
  std::vector<int> diagonal_;
  std::vector<Eigen::Matrix3d> block_;
};

}  // namespace kerf::fem
