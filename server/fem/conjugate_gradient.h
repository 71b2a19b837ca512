#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/fem/linear_solver.h"
#include "server/mesh/vertex_field.h"

namespace kerf::fem {

enum class Preconditioner {
  kNone,
  kJacobi,       // the inverse diagonal
  kBlockJacobi,  // the inverses of the 3x3 diagonal blocks
};

// Conjugate gradients (Hestenes, Stiefel 1952), preconditioned or not.
class ConjugateGradient final : public LinearSolver {
 public:
  ConjugateGradient(Preconditioner preconditioner, int max_iterations)
      : preconditioner_(preconditioner), max_iterations_(max_iterations) {}

  void analyse(const BlockMatrix& A) override;
  LinearStats solve(const BlockMatrix& A, const mesh::VertexField& b, double tolerance, mesh::VertexField& x) override;
  // The same of a dense A, 3N x 3N, N that of analyse().
  LinearStats solve(const Eigen::MatrixXd& A, const mesh::VertexField& b, double tolerance, mesh::VertexField& x);

 private:
  // diagonal_block(i): the 3x3 block of A.
  template <typename DiagonalBlock>
  void prepare(const DiagonalBlock& diagonal_block);
  // multiply(x, y): y = A x.
  template <typename Multiply>
  LinearStats iterate(const Multiply& multiply, const mesh::VertexField& b, double tolerance, mesh::VertexField& x);
  void precondition();  // z_ = P^-1 r_

  Preconditioner preconditioner_;
  int max_iterations_;
  std::vector<Eigen::Matrix3d> inverse_diagonal_;  // P^-1; empty without a preconditioner
  mesh::VertexField r_, z_, p_, Ap_;               // 3 x N
};

}  // namespace kerf::fem
