#include "server/core/linear/block_matrix.h"

#include <algorithm>
#include <utility>

namespace kerf::linear {

void BlockMatrix::resize(int num_rows) {
  for (int i = num_rows; i < this->num_rows(); ++i) num_blocks_ -= rows_[static_cast<std::size_t>(i)].size;
  rows_.resize(static_cast<std::size_t>(num_rows));
}

void BlockMatrix::reserve(std::size_t num_blocks) {
  column_.reserve(num_blocks);
  block_.reserve(num_blocks);
}

void BlockMatrix::set_row(int i, std::span<const int> columns) {
  Row& row = rows_[static_cast<std::size_t>(i)];
  const auto size = static_cast<int>(columns.size());
  num_blocks_ += size - row.size;
  row.size = size;
  if (size > row.capacity) {
    row.begin = static_cast<int>(column_.size());
    row.capacity = size;
    column_.resize(column_.size() + columns.size());
    block_.resize(column_.size(), Eigen::Matrix3d::Zero());
  }
  std::copy(columns.begin(), columns.end(), column_.begin() + row.begin);
  row.diagonal = static_cast<int>(std::lower_bound(columns.begin(), columns.end(), i) - columns.begin());
  if (static_cast<int>(column_.size()) > 2 * num_blocks_ + kSlack) pack();
}

void BlockMatrix::pack() {
  std::vector<int> packed;
  packed.reserve(static_cast<std::size_t>(num_blocks_));
  for (Row& row : rows_) {
    const auto from = column_.begin() + row.begin;
    row.begin = static_cast<int>(packed.size());
    row.capacity = row.size;
    packed.insert(packed.end(), from, from + row.size);
  }
  column_ = std::move(packed);
  block_.resize(column_.size());
}

int BlockMatrix::find(int i, int j) const {
  const auto begin = column_.begin() + row_begin(i);
  const auto end = column_.begin() + row_end(i);
  const auto at = std::lower_bound(begin, end, j);
  return at != end && *at == j ? static_cast<int>(at - column_.begin()) : -1;
}

void BlockMatrix::set_zero() {
  for (Eigen::Matrix3d& block : block_) block.setZero();
}

void BlockMatrix::multiply(const VertexField& x, VertexField& y) const {
  for (int i = 0; i < num_rows(); ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int at = row_begin(i); at < row_end(i); ++at) sum.noalias() += block(at) * x.col(column(at));
    y.col(i) = sum;
  }
}

}  // namespace kerf::linear
