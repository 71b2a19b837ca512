#include <algorithm>

#include "server/fem/preconditioner.h"
#include "server/fem/supernodal_cholesky.h"

namespace kerf::fem {
namespace {

// Flops of a factorisation go so much faster than those of a solve, which waits for memory, and an iteration has a
// product beside its solve: measured, 50 x 50 and 100 x 100 vertices.
constexpr double kFlopsPerFlop = 12.0;
constexpr double kLeastPatience = 4.0;
constexpr double kMostPatience = 30.0;

// z = Q L^-T L^-1 Q^T r, L L^T = R^T A R, A an earlier matrix, R its frames and Q those of now: as the sheet turns, its
// stiffness turns with it. In frames, floats also tell the weak bending of a stiff sheet from its stretching, whichever
// way it faces.
class FactorPreconditioner final : public Preconditioner {
 public:
  void analyse(const BlockMatrix& A) override {
    factor_.analyse(A);
    frames_.assign(static_cast<std::size_t>(A.num_rows()), Eigen::Matrix3d::Identity());
    turned_.resize(A.num_rows());
    patience_ = static_cast<int>(
        std::clamp(factor_.factor_flops() / (kFlopsPerFlop * factor_.solve_flops()), kLeastPatience, kMostPatience));
    forget();
  }

  bool prepare(const BlockMatrix& A) override {
    if (was_renewed_) has_factor_ = false;
    was_renewed_ = false;
    is_old_ = has_factor_;
    return has_factor_ || factorise(A);
  }

  void apply(const mesh::VertexField& r, mesh::VertexField& z) override {
    const double largest = r.cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) {
      z = r;
      return;
    }
    const double scale = 1.0 / largest;  // floats have their limits
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      turned_.col(column) = frames_[i].transpose() * (scale * r.col(column));
    }
    factor_.solve(turned_, turned_);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      z.col(column) = frames_[i] * (largest * turned_.col(column));
    }
  }

  [[nodiscard]] int patience() const override { return is_old_ ? patience_ : 0; }
  bool renew(const BlockMatrix& A) override {
    was_renewed_ = true;
    return factorise(A);
  }
  void forget() override { has_factor_ = false; }
  std::vector<Eigen::Matrix3d>* frames() override { return &frames_; }

 private:
  bool factorise(const BlockMatrix& A) {
    PivotRule<float> rule;
    rule.replaces = true;  // any positive definite factor will do
    has_factor_ = factor_.factorise(A, frames_, rule);
    is_old_ = false;
    return has_factor_;
  }

  SupernodalCholesky<float> factor_;
  std::vector<Eigen::Matrix3d> frames_;
  mesh::VertexField turned_;  // 3 x N
  int patience_ = 0;
  bool has_factor_ = false;
  bool was_renewed_ = false;
  bool is_old_ = false;  // of an earlier matrix than that of prepare()
};

}  // namespace

std::unique_ptr<Preconditioner> make_factor_preconditioner() {
  return std::make_unique<FactorPreconditioner>();
}

}  // namespace kerf::fem
