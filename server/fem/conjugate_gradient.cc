#include "server/fem/conjugate_gradient.h"

#include <cmath>

#include <Eigen/LU>

namespace kerf::fem {
namespace {

double dot(const mesh::VertexField& a, const mesh::VertexField& b) {
  const double* const pa = a.data();
  const double* const pb = b.data();
  double sum = 0.0;
  for (Eigen::Index i = 0; i < a.size(); ++i) sum += pa[i] * pb[i];
  return sum;
}

}  // namespace

void ConjugateGradient::analyse(const BlockMatrix& A) {
  if (preconditioner_ != Preconditioner::kNone) inverse_diagonal_.resize(static_cast<std::size_t>(A.num_rows()));
  for (mesh::VertexField* vector : {&r_, &z_, &p_, &Ap_}) vector->resize(A.num_rows());
}

template <typename DiagonalBlock>
void ConjugateGradient::prepare(const DiagonalBlock& diagonal_block) {
  for (std::size_t i = 0; i < inverse_diagonal_.size(); ++i) {
    const Eigen::Matrix3d block = diagonal_block(static_cast<int>(i));
    if (preconditioner_ == Preconditioner::kJacobi) {
      inverse_diagonal_[i] = block.diagonal().cwiseInverse().asDiagonal();
    } else {
      inverse_diagonal_[i] = block.inverse();
    }
  }
}

void ConjugateGradient::precondition() {
  if (preconditioner_ == Preconditioner::kNone) {
    z_ = r_;
    return;
  }
  for (std::size_t i = 0; i < inverse_diagonal_.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    z_.col(column).noalias() = inverse_diagonal_[i] * r_.col(column);
  }
}

LinearStats ConjugateGradient::solve(const BlockMatrix& A, const mesh::VertexField& b, double tolerance,
                                     mesh::VertexField& x) {
  prepare([&A](int i) -> const Eigen::Matrix3d& { return A.block(A.diagonal(i)); });
  return iterate([&A](const mesh::VertexField& p, mesh::VertexField& Ap) { A.multiply(p, Ap); }, b, tolerance, x);
}

LinearStats ConjugateGradient::solve(const Eigen::MatrixXd& A, const mesh::VertexField& b, double tolerance,
                                     mesh::VertexField& x) {
  prepare([&A](int i) -> Eigen::Matrix3d { return A.block<3, 3>(3 * i, 3 * i); });
  const auto multiply = [&A](const mesh::VertexField& p, mesh::VertexField& Ap) {
    Eigen::Map<Eigen::VectorXd> result(Ap.data(), Ap.size());
    result.noalias() = A * Eigen::Map<const Eigen::VectorXd>(p.data(), p.size());
  };
  return iterate(multiply, b, tolerance, x);
}

template <typename Multiply>
LinearStats ConjugateGradient::iterate(const Multiply& multiply, const mesh::VertexField& b, double tolerance,
                                       mesh::VertexField& x) {
  LinearStats stats;
  const double b_norm = std::sqrt(dot(b, b));
  if (b_norm == 0.0) {
    x.setZero();
    stats.converged = true;
    return stats;
  }
  multiply(x, Ap_);
  r_ = b - Ap_;
  precondition();
  p_ = z_;
  double rz = dot(r_, z_);
  while (true) {
    const double r_norm = std::sqrt(dot(r_, r_));
    stats.converged = r_norm <= tolerance * b_norm;
    if (stats.converged || stats.iterations == max_iterations_ || !std::isfinite(r_norm)) break;
    multiply(p_, Ap_);
    const double curvature = dot(p_, Ap_);
    if (!(curvature > 0.0)) break;  // not positive definite
    const double alpha = rz / curvature;
    x += alpha * p_;
    r_ -= alpha * Ap_;
    precondition();
    const double rz_next = dot(r_, z_);
    p_ = z_ + (rz_next / rz) * p_;
    rz = rz_next;
    ++stats.iterations;
  }
  multiply(x, Ap_);
  r_ = b - Ap_;
  stats.residual = std::sqrt(dot(r_, r_)) / b_norm;
  if (!x.allFinite()) stats.converged = false;
  return stats;
}

}  // namespace kerf::fem
