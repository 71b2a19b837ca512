#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/linear/vertex_field.h"

namespace kerf::linear {

// Square sparse matrix of 3x3 blocks, stored by rows: columns ascend within a row, and the diagonal is always present.
// Matrices are symmetric by use; both triangles are stored, so that a product reads memory in order. The pattern of a
// row can be replaced without touching the others. A row that outgrows its place moves to the end. All rows are packed
// again once more than half of the storage is holes.
class BlockMatrix {
 public:
  // Adds empty rows or drops the rows beyond `num_rows`.
  void resize(int num_rows);
  // Reserves storage, so that `num_blocks` fit without a copy. Unused storage takes no memory.
  void reserve(std::size_t num_blocks);
  // Sets the pattern of row i; `columns` ascend and contain i. The values of all rows are then undefined until
  // set_zero(). Positions of blocks of any row, obtained before, are no longer valid.
  void set_row(int i, std::span<const int> columns);

  [[nodiscard]] int num_rows() const { return static_cast<int>(rows_.size()); }
  [[nodiscard]] int num_blocks() const { return num_blocks_; }

  // Blocks of row i are those at positions [row_begin(i), row_end(i)).
  [[nodiscard]] int row_begin(int i) const { return rows_[static_cast<std::size_t>(i)].begin; }
  [[nodiscard]] int row_end(int i) const {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    return row.begin + row.size;
  }
  [[nodiscard]] int column(int position) const { return column_[static_cast<std::size_t>(position)]; }
  [[nodiscard]] int diagonal(int i) const {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    return row.begin + row.diagonal;
  }
  // Returns the position of block (i, j), or -1 if the pattern has none. Binary search.
  [[nodiscard]] int find(int i, int j) const;

  [[nodiscard]] Eigen::Matrix3d& block(int position) { return block_[static_cast<std::size_t>(position)]; }
  [[nodiscard]] const Eigen::Matrix3d& block(int position) const { return block_[static_cast<std::size_t>(position)]; }

  void set_zero();
  // Computes y = A x. x and y are 3 x N; y must not alias x.
  void multiply(const VertexField& x, VertexField& y) const;

 private:
  struct Row {
    int begin = 0;
    int size = 0;
    int capacity = 0;
    int diagonal = 0;  // offset from `begin`
  };
  static constexpr int kSlack = 1024;  // blocks; packing smaller arrays gains nothing

  void pack();

  std::vector<Row> rows_;
  std::vector<int> column_;
  std::vector<Eigen::Matrix3d> block_;
  int num_blocks_ = 0;
};

}  // namespace kerf::linear
