#include "server/fem/block_matrix.h"

#include <algorithm>

namespace kerf::fem {

void BlockMatrix::set_pattern(const std::vector<std::vector<int>>& columns) {
  row_begin_.assign(1, 0);
  column_.clear();
  diagonal_.clear();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    column_.insert(column_.end(), columns[i].begin(), columns[i].end());
    row_begin_.push_back(static_cast<int>(column_.size()));
  }
  block_.assign(column_.size(), Eigen::Matrix3d::Zero());
  for (int i = 0; i < num_rows(); ++i) diagonal_.push_back(find(i, i));
}

int BlockMatrix::find(int i, int j) const {
  const auto begin = column_.begin() + row_begin(i);
  const auto end = column_.begin() + row_begin(i + 1);
  const auto at = std::lower_bound(begin, end, j);
  return at != end && *at == j ? static_cast<int>(at - column_.begin()) : -1;
}

void BlockMatrix::set_zero() {
  for (Eigen::Matrix3d& block : block_) block.setZero();
}

void BlockMatrix::multiply(const Eigen::Matrix3Xd& x, Eigen::Matrix3Xd& y) const {
  for (int i = 0; i < num_rows(); ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int at = row_begin(i); at < row_begin(i + 1); ++at) sum.noalias() += block(at) * x.col(column(at));
    y.col(i) = sum;
  }
}

}  // namespace kerf::fem
