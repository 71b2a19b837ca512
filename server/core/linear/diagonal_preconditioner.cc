#include <Eigen/LU>

#include "server/core/linear/preconditioner.h"

namespace kerf::linear {
namespace {

class NoPreconditioner final : public Preconditioner {
 public:
  void analyse(const BlockMatrix& /*A*/) override {}
  bool prepare(const BlockMatrix& /*A*/) override { return true; }
  void apply(const VertexField& r, VertexField& z) override { z = r; }
};

class DiagonalPreconditioner final : public Preconditioner {
 public:
  explicit DiagonalPreconditioner(bool by_blocks) : by_blocks_(by_blocks) {}

  void analyse(const BlockMatrix& A) override { inverse_.resize(static_cast<std::size_t>(A.num_rows())); }

  bool prepare(const BlockMatrix& A) override {
    for (std::size_t i = 0; i < inverse_.size(); ++i) {
      const Eigen::Matrix3d& block = A.block(A.diagonal(static_cast<int>(i)));
      if (by_blocks_) {
        inverse_[i] = block.inverse();
      } else {
        inverse_[i] = block.diagonal().cwiseInverse().asDiagonal();
      }
    }
    return true;
  }

  void apply(const VertexField& r, VertexField& z) override {
    for (std::size_t i = 0; i < inverse_.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      z.col(column).noalias() = inverse_[i] * r.col(column);
    }
  }

 private:
  bool by_blocks_;
  std::vector<Eigen::Matrix3d> inverse_;
};

}  // namespace

std::unique_ptr<Preconditioner> make_diagonal_preconditioner(Diagonal diagonal) {
  if (diagonal == Diagonal::kOnes) return std::make_unique<NoPreconditioner>();
  return std::make_unique<DiagonalPreconditioner>(diagonal == Diagonal::kBlocks);
}

}  // namespace kerf::linear
