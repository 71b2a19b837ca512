#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "server/core/linear/preconditioner.h"
#include "server/core/linear/supernodal_cholesky.h"

namespace kerf::linear {

// Preconditioner from a Cholesky factor in single precision: z = Q L^-T L^-1 Q^T r with L L^T = R^T A R. The factor is
// kept from one matrix to the next, so A may be an earlier matrix than that of the solve. R holds the frames of the
// vertices when A was factored, Q the present ones. They make the factor turn with the sheet, as its stiffness does. In
// these frames floats also resolve the weak bending of a stiff sheet beside its stretching, in any orientation.
class FactorPreconditioner final : public Preconditioner {
 public:
  static constexpr int kMaxReuseIterations = 30;  // largest value of max_reuse_iterations()

  void analyse(const BlockMatrix& A) override;
  bool prepare(const BlockMatrix& A) override;
  void apply(const VertexField& r, VertexField& z) override;
  [[nodiscard]] int max_reuse_iterations() const override { return is_old_ ? max_reuse_iterations_ : 0; }
  bool refactor(const BlockMatrix& A) override;
  void reset() override { has_factor_ = false; }
  void set_stop_condition(const StopCondition* stop) override { factor_.set_stop_condition(stop); }
  std::vector<Eigen::Matrix3d>* frames() override { return &frames_; }
  [[nodiscard]] const std::shared_ptr<const Supernodes>& supernodes() const { return factor_.supernodes(); }

 private:
  bool factorise(const BlockMatrix& A);

  SupernodalCholesky<float> factor_;
  std::vector<Eigen::Matrix3d> frames_;
  VertexField turned_;  // 3 x N
  int max_reuse_iterations_ = 0;
  bool has_factor_ = false;
  // True if refactor() was called since the last prepare(); the next prepare() then makes a new factor.
  bool was_refactored_ = false;
  bool is_old_ = false;  // the factor is of an earlier matrix than that of prepare()
};

}  // namespace kerf::linear
