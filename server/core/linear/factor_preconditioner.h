#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "server/core/linear/preconditioner.h"
#include "server/core/linear/supernodal_cholesky.h"

namespace kerf::fem {

// Preconditioner from a Cholesky factor in single precision, kept from an earlier matrix if there was one, in frames
// that turn with the sheet: z = Q L^-T L^-1 Q^T r, L L^T = R^T A R. A is the earlier matrix, R holds its frames and Q
// the present ones: the stiffness of a sheet turns with it. In these frames floats also resolve the weak bending of a
// stiff sheet beside its stretching, in any orientation.
class FactorPreconditioner final : public Preconditioner {
 public:
  static constexpr int kMaxReuseIterations = 30;  // iterations

  void analyse(const BlockMatrix& A) override;
  bool prepare(const BlockMatrix& A) override;
  void apply(const mesh::VertexField& r, mesh::VertexField& z) override;
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
  mesh::VertexField turned_;  // 3 x N
  int max_reuse_iterations_ = 0;
  bool has_factor_ = false;
  bool was_refactored_ = false;
  bool is_old_ = false;  // the factor is of an earlier matrix than that of prepare()
};

}  // namespace kerf::fem
