#include "server/core/linear/conjugate_gradient.h"

#include <cmath>

#include "server/base/elementary.h"

namespace kerf::linear {
namespace {

double dot(const VertexField& a, const VertexField& b) {
  const double* const pa = a.data();
  const double* const pb = b.data();
  double sum = 0.0;
  for (Eigen::Index i = 0; i < a.size(); ++i) sum += pa[i] * pb[i];
  return sum;
}

}  // namespace

void ConjugateGradient::analyse(const BlockMatrix& A) {
  preconditioner_->analyse(A);
  for (VertexField* vector : {&r_, &z_, &p_, &Ap_}) vector->resize(A.num_rows());
}

LinearStats ConjugateGradient::solve(const BlockMatrix& A, const VertexField& b, double tolerance, VertexField& x) {
  const auto multiply = [&A](const VertexField& p, VertexField& Ap) { A.multiply(p, Ap); };
  if (!preconditioner_->prepare(A)) return {0, true_residual(multiply, b, x), false};
  return iterate(
      multiply, [&] { return preconditioner_->refactor(A); }, b, tolerance, x);
}

LinearStats ConjugateGradient::solve(const Eigen::MatrixXd& A, const VertexField& b, double tolerance, VertexField& x) {
  const auto multiply = [&A](const VertexField& p, VertexField& Ap) {
    Eigen::Map<Eigen::VectorXd> result(Ap.data(), Ap.size());
    result.noalias() = A * Eigen::Map<const Eigen::VectorXd>(p.data(), p.size());
  };
  return iterate(
      multiply, [] { return false; }, b, tolerance, x);
}

template <typename Multiply, typename Refactor>
LinearStats ConjugateGradient::iterate(const Multiply& multiply, const Refactor& refactor, const VertexField& b,
                                       double tolerance, VertexField& x) {
  LinearStats stats;
  const double b_norm = std::sqrt(dot(b, b));
  if (b_norm == 0.0) {
    x.setZero();
    stats.converged = true;
    return stats;
  }
  double rz = restart(multiply, b, x);
  int since_restart = 0;
  double first_norm = 0.0;  // norm of r at the restart
  while (true) {
    const double r_norm = std::sqrt(dot(r_, r_));
    stats.converged = r_norm <= tolerance * b_norm;
    if (stats.converged || stats.iterations == max_iterations_ || !std::isfinite(r_norm) || stop_.is_met()) break;
    if (since_restart == 0) first_norm = r_norm;
    if (is_too_slow(since_restart, r_norm / first_norm, tolerance * b_norm / first_norm)) {
      if (!refactor()) break;
      rz = restart(multiply, b, x);
      since_restart = 0;
    }
    multiply(p_, Ap_);
    const double curvature = dot(p_, Ap_);
    if (!(curvature > 0.0)) break;  // not positive definite
    const double alpha = rz / curvature;
    x += alpha * p_;
    r_ -= alpha * Ap_;
    preconditioner_->apply(r_, z_);
    const double rz_next = dot(r_, z_);
    p_ = z_ + (rz_next / rz) * p_;
    rz = rz_next;
    ++stats.iterations;
    ++since_restart;
  }
  stats.residual = true_residual(multiply, b, x);
  if (!x.allFinite()) stats.converged = false;
  return stats;
}

template <typename Multiply>
double ConjugateGradient::true_residual(const Multiply& multiply, const VertexField& b, const VertexField& x) {
  multiply(x, Ap_);
  r_ = b - Ap_;
  const double b_norm = std::sqrt(dot(b, b));
  return b_norm > 0.0 ? std::sqrt(dot(r_, r_)) / b_norm : 0.0;
}

template <typename Multiply>
double ConjugateGradient::restart(const Multiply& multiply, const VertexField& b, const VertexField& x) {
  multiply(x, Ap_);
  r_ = b - Ap_;
  preconditioner_->apply(r_, z_);
  p_ = z_;
  return dot(r_, z_);
}

bool ConjugateGradient::is_too_slow(int iterations, double reached, double wanted) const {
  constexpr int kFirstJudged = 2;
  const int max_reuse_iterations = preconditioner_->max_reuse_iterations();
  if (max_reuse_iterations == 0 || iterations < kFirstJudged) return false;
  return reached >= 1.0 || iterations * logarithm(wanted) / logarithm(reached) > max_reuse_iterations;
}

}  // namespace kerf::linear
