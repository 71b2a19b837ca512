#include "tests/bench/corrected_factor.h"

namespace kerf::bench {

void CorrectedFactor::analyse(const linear::BlockMatrix& A) {
  const auto size = static_cast<int>(part_.size());
  place_.assign(static_cast<std::size_t>(A.num_rows()), -1);
  for (int i = 0; i < size; ++i) place_[static_cast<std::size_t>(part_[static_cast<std::size_t>(i)])] = i;
  A_SS_.resize(size);
  std::vector<int> columns;
  for (int i = 0; i < size; ++i) {
    const int row = part_[static_cast<std::size_t>(i)];
    columns.clear();
    for (int at = A.row_begin(row); at < A.row_end(row); ++at) {
      const int j = place_[static_cast<std::size_t>(A.column(at))];
      if (j >= 0) columns.push_back(j);
    }
    A_SS_.set_row(i, columns);
  }
  if (size > 0) factor_.analyse(A_SS_);
  old_r_.resize(num_before_);
  old_z_.resize(num_before_);
  of_part_.resize(size);
}

bool CorrectedFactor::prepare(const linear::BlockMatrix& A) {
  if (A_ == &A) return true;  // for start(), before conjugate gradients ask for it
  A_ = &A;
  for (int i = 0; i < A_SS_.num_rows(); ++i) {
    const int row = part_[static_cast<std::size_t>(i)];
    int to = A_SS_.row_begin(i);
    for (int at = A.row_begin(row); at < A.row_end(row); ++at) {
      if (place_[static_cast<std::size_t>(A.column(at))] >= 0) A_SS_.block(to++) = A.block(at);
    }
  }
  linear::PivotRule<double> rule;
  return part_.empty() || factor_.factorise(A_SS_, {}, rule);
}

void CorrectedFactor::apply(const linear::VertexField& r, linear::VertexField& z) {
  old_r_ = r.leftCols(num_before_);
  before_.apply(old_r_, old_z_);
  z.setZero();
  z.leftCols(num_before_) = old_z_;
  if (!part_.empty()) correct(r, z);
}

void CorrectedFactor::start(const linear::VertexField& b, linear::VertexField& x) {
  if (!part_.empty()) correct(b, x);
}

void CorrectedFactor::correct(const linear::VertexField& b, linear::VertexField& x) {
  for (Eigen::Index i = 0; i < of_part_.cols(); ++i) {
    const int row = part_[static_cast<std::size_t>(i)];
    Eigen::Vector3d sum = b.col(row);
    for (int at = A_->row_begin(row); at < A_->row_end(row); ++at) sum -= A_->block(at) * x.col(A_->column(at));
    of_part_.col(i) = sum;
  }
  factor_.solve(of_part_, of_part_);
  for (Eigen::Index i = 0; i < of_part_.cols(); ++i) x.col(part_[static_cast<std::size_t>(i)]) += of_part_.col(i);
}

}  // namespace kerf::bench
