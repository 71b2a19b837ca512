#pragma once

#include <memory>
#include <utility>

#include <Eigen/Core>

#include "server/core/linear/linear_solver.h"
#include "server/core/linear/preconditioner.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::linear {

// Conjugate gradient method (Hestenes, Stiefel 1952), with or without a preconditioner.
class ConjugateGradient final : public LinearSolver {
 public:
  ConjugateGradient(std::unique_ptr<Preconditioner> preconditioner, int max_iterations)
      : preconditioner_(std::move(preconditioner)), max_iterations_(max_iterations) {}

  void analyse(const BlockMatrix& A) override;
  LinearStats solve(const BlockMatrix& A, const VertexField& b, double tolerance, VertexField& x) override;
  // Solves with a dense A, 3N x 3N, with the N of analyse(). The preconditioner must not depend on A.
  LinearStats solve(const Eigen::MatrixXd& A, const VertexField& b, double tolerance, VertexField& x);

  void reset() override { preconditioner_->reset(); }
  void set_stop_condition(const StopCondition* stop) override {
    stop_.set(stop);
    preconditioner_->set_stop_condition(stop);
  }
  std::vector<Eigen::Matrix3d>* frames() override { return preconditioner_->frames(); }
  VertexField* positions() override { return preconditioner_->positions(); }

 private:
  // Runs the iteration. multiply(x, y) sets y = A x; for refactor() see Preconditioner.
  template <typename Multiply, typename Refactor>
  LinearStats iterate(const Multiply& multiply, const Refactor& refactor, const VertexField& b, double tolerance,
                      VertexField& x);
  // Returns |b - A x| / |b|, or 0 if b = 0.
  template <typename Multiply>
  double true_residual(const Multiply& multiply, const VertexField& b, const VertexField& x);
  // Sets the residual and the direction at x with the preconditioner as it is. Returns r.z.
  template <typename Multiply>
  double restart(const Multiply& multiply, const VertexField& b, const VertexField& x);
  // Returns true if the preconditioner is too old to be worth keeping. After `iterations` the norm of the residual has
  // fallen to the fraction `reached`, and has to fall to `wanted`.
  [[nodiscard]] bool is_too_slow(int iterations, double reached, double wanted) const;

  std::unique_ptr<Preconditioner> preconditioner_;
  int max_iterations_;
  StopPoll stop_;
  VertexField r_, z_, p_, Ap_;  // 3 x N
};

}  // namespace kerf::linear
