#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "server/base/stop_condition.h"
#include "server/core/linear/block_matrix.h"
#include "server/core/linear/linear_solver_kind.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::linear {

struct LinearStats {
  int iterations = 0;     // CG iterations; 1 for the direct solver
  double residual = 0.0;  // |b - A x| / |b| in the Euclidean norm, recomputed from the returned x; 0 where b = 0
  // True if the residual is at most the tolerance; conjugate gradients test the residual of their recurrence instead.
  // False also if A was found not positive definite or x is not finite.
  bool converged = false;
};

// Solves A x = b for a symmetric positive definite A of 3x3 blocks. Solvers with
// LinearSolverName::solves_different_system solve another system in its place.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  // Takes the sparsity pattern; may allocate. Must be called whenever the pattern changes.
  virtual void analyse(const BlockMatrix& A) = 0;

  // Solves for x. b and x are 3 x N with N = A.num_rows(); x holds the initial guess. The solve has converged when |b -
  // A x| <= tolerance |b|. Never allocates.
  virtual LinearStats solve(const BlockMatrix& A, const VertexField& b, double tolerance, VertexField& x) = 0;

  // Discards all data of earlier matrices, so that they have no influence on later solves.
  virtual void reset() {}
  // Sets the stop condition, polled once an iteration and at the start of a factorisation. A stopped solve has not
  // converged.
  virtual void set_stop_condition(const StopCondition* stop) = 0;
  // Rotation of each vertex (see find_vertex_frames), to be set before a solve. Null if the solver does not use it.
  virtual std::vector<Eigen::Matrix3d>* frames() { return nullptr; }
  // Positions of the vertices, 3 x N, m, up to a translation, to be set before a solve. Null if the solver does not use
  // them.
  virtual VertexField* positions() { return nullptr; }
};

// Makes a solver. `max_iterations` limits the iterations of a solve; kDirect ignores it. `root` applies to kEsCgm and
// kAsCgm only.
std::unique_ptr<LinearSolver> make_linear_solver(LinearSolverKind kind, int max_iterations,
                                                 const CovarianceRootOptions& root = {});

}  // namespace kerf::linear
