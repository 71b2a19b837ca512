#pragma once

#include <cmath>
#include <ostream>
#include <utility>

#include <Eigen/Core>

#include <gmock/gmock.h>

namespace kerf::test {

// See MatrixNear().
class MatrixNearMatcher {
 public:
  using is_gtest_matcher = void;

  MatrixNearMatcher(Eigen::MatrixXd expected, double tolerance)
      : expected_(std::move(expected)), tolerance_(tolerance) {}

  template <typename Actual>
  bool MatchAndExplain(const Actual& actual, testing::MatchResultListener* listener) const {
    const Eigen::MatrixXd found = actual;
    if (found.rows() != expected_.rows() || found.cols() != expected_.cols()) {
      *listener << "which has " << found.rows() << " x " << found.cols() << " entries";
      return false;
    }
    Eigen::Index row = 0;
    Eigen::Index column = 0;
    double largest = -1.0;
    for (Eigen::Index j = 0; j < found.cols(); ++j) {
      for (Eigen::Index i = 0; i < found.rows(); ++i) {
        const double difference = std::abs(found(i, j) - expected_(i, j));
        if (!(largest >= difference)) largest = difference, row = i, column = j;
        if (std::isnan(difference)) return explain(found, i, j, listener), false;
      }
    }
    if (largest >= 0.0) explain(found, row, column, listener);
    return largest < tolerance_;
  }

  void DescribeTo(std::ostream* out) const {
    *out << "is a matrix of " << expected_.rows() << " x " << expected_.cols() << " entries, each nearer than "
         << tolerance_ << " to the one expected";
  }
  void DescribeNegationTo(std::ostream* out) const {
    *out << "is not a matrix of " << expected_.rows() << " x " << expected_.cols() << " entries, each nearer than "
         << tolerance_ << " to the one expected";
  }

 private:
  void explain(const Eigen::MatrixXd& found, Eigen::Index row, Eigen::Index column,
               testing::MatchResultListener* listener) const {
    *listener << "whose entry (" << row << ", " << column << ") is " << found(row, column) << ", not "
              << expected_(row, column) << ": the difference " << found(row, column) - expected_(row, column)
              << " is the largest";
  }

  Eigen::MatrixXd expected_;
  double tolerance_;
};

// Matches a matrix whose entries all differ from those of `expected` by less than `tolerance`. A failure says where the
// largest difference is. NaN is near nothing.
template <typename Expected>
MatrixNearMatcher MatrixNear(const Eigen::MatrixBase<Expected>& expected, double tolerance) {
  return {Eigen::MatrixXd(expected), tolerance};
}

}  // namespace kerf::test
