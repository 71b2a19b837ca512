#include "server/core/linear/skew_correction.h"

#include <cmath>

namespace kerf::linear {
namespace {

constexpr int kMaxIterations = 50;

}  // namespace

LinearStats SkewCorrection::solve(DirectSolver& solver, const BlockMatrix& A, const BlockMatrix& N,
                                  const VertexField& b, double tolerance, VertexField& x) {
  for (VertexField* field : {&residual_, &step_, &product_}) field->resize(x.cols());
  LinearStats stats;
  const double scale = b.norm();
  current_ = x;
  previous_ = x;
  double omega = 1.0;
  double before = 0.0;
  for (; scale > 0.0; ++stats.iterations) {
    A.multiply(current_, residual_);
    N.multiply(current_, product_);
    residual_ = b - residual_ - product_;
    const double relative = residual_.norm() / scale;
    if (!std::isfinite(relative)) break;
    if (stats.iterations == 0 || relative < stats.residual) {
      stats.residual = relative;
      x = current_;
    }
    stats.converged = stats.residual <= tolerance;
    if (stats.converged || stats.iterations == kMaxIterations) break;
    solver.solve_again(residual_, step_);
    const double size = residual_.cwiseProduct(step_).sum();
    if (stats.iterations > 0) omega = 1.0 / (1.0 + size / (before * omega));
    before = size;
    step_ = previous_ + omega * (step_ + current_ - previous_);
    previous_ = current_;
    current_ = step_;
  }
  return stats;
}

}  // namespace kerf::linear
