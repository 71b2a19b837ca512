#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "server/base/stop_condition.h"
#include "server/core/linear/block_matrix.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::linear {

// Preconditioner P, symmetric positive definite, for conjugate gradients on a matrix of 3x3 blocks. Only analyse()
// allocates.
class Preconditioner {
 public:
  virtual ~Preconditioner() = default;

  // Takes the sparsity pattern.
  virtual void analyse(const BlockMatrix& A) = 0;
  // Prepares solves with A. Returns false if there is no P for it.
  virtual bool prepare(const BlockMatrix& A) = 0;
  // Sets z = P^-1 r; both are 3 x N.
  virtual void apply(const VertexField& r, VertexField& z) = 0;

  // Number of iterations up to which P from an earlier matrix is good enough. If a solve would take more, refactor()
  // makes P from A. 0 means that P is already current or cannot be improved.
  [[nodiscard]] virtual int max_reuse_iterations() const { return 0; }
  virtual bool refactor(const BlockMatrix& /*A*/) { return false; }
  // Discards data of earlier matrices, so that they have no influence on later solves.
  virtual void reset() {}
  // Sets the stop condition, see LinearSolver. A factorisation that it ends leaves no P.
  virtual void set_stop_condition(const StopCondition* /*stop*/) {}
  virtual std::vector<Eigen::Matrix3d>* frames() { return nullptr; }
  virtual VertexField* positions() { return nullptr; }
};

enum class Diagonal {
  kOnes,     // no preconditioner
  kEntries,  // Jacobi: the inverse diagonal
  kBlocks,   // block-Jacobi: the inverses of the 3x3 diagonal blocks
};
std::unique_ptr<Preconditioner> make_diagonal_preconditioner(Diagonal diagonal);

}  // namespace kerf::linear
