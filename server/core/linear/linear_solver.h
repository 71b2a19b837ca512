#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "server/core/linear/block_matrix.h"
#include "server/core/linear/goes_on.h"
#include "server/core/linear/linear_solver_kind.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

struct LinearStats {
  int iterations = 0;      // CG iterations; 1 for the direct solver
  double residual = 0.0;   // |b - A x| / |b| in the Euclidean norm, recomputed from the returned x; 0 where b = 0
  bool converged = false;  // residual <= tolerance (CG: of its recurrence); false also when A was found not positive
                           // definite or x not finite
};

// Solves A x = b for a symmetric positive definite A of 3x3 blocks, but those that solve a different system (see
// LinearSolverName), which never do.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  // Takes the sparsity pattern; may allocate. To be called whenever the pattern changes.
  virtual void analyse(const BlockMatrix& A) = 0;

  // b, x: 3 x N with N = A.num_rows(). x holds the initial guess and becomes the solution. Converged when
  // |b - A x| <= tolerance |b|. Never allocates.
  virtual LinearStats solve(const BlockMatrix& A, const mesh::VertexField& b, double tolerance,
                            mesh::VertexField& x) = 0;

  // Nothing of the matrices so far is to have an influence on the solves to come.
  virtual void forget() {}
  // Solves to come ask `goes_on` once an iteration and front of a factorisation; one that it ends has not converged.
  virtual void heed(const GoesOn* goes_on) = 0;
  // Where the solver wants to know how vertices have turned, a rotation of each (see find_vertex_frames), to be set
  // before a solve; null for others.
  virtual std::vector<Eigen::Matrix3d>* frames() { return nullptr; }
  // Likewise where they are, 3 x N, m, up to a translation.
  virtual mesh::VertexField* positions() { return nullptr; }
};

// max_iterations limits the iterative solvers; the direct one ignores it.
// `root` is of those that solve a different system.
std::unique_ptr<LinearSolver> make_linear_solver(LinearSolverKind kind, int max_iterations,
                                                 const CovarianceRootOptions& root = {});

}  // namespace kerf::fem
