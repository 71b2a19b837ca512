#pragma once

#include <vector>

#include "server/fem/linear_solver.h"
#include "server/mesh/vertex_field.h"

namespace kerf::fem {

// Conjugate gradients (Hestenes, Stiefel 1952) preconditioned with the inverses of the 3x3 diagonal blocks: these,
// other than the diagonal alone, follow the rotation of the sheet.
class ConjugateGradient final : public LinearSolver {
 public:
  explicit ConjugateGradient(int max_iterations) : max_iterations_(max_iterations) {}

  void analyse(const BlockMatrix& A) override;
  LinearStats solve(const BlockMatrix& A, const mesh::VertexField& b, double tolerance, mesh::VertexField& x) override;

 private:
  void precondition();  // z_ = P^-1 r_

  int max_iterations_;
  std::vector<Eigen::Matrix3d> inverse_diagonal_;
  mesh::VertexField r_, z_, p_, Ap_;  // 3 x N
};

}  // namespace kerf::fem
