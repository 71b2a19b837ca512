#pragma once

#include <functional>

#include "server/fem/block_cholesky.h"
#include "server/fem/loads.h"
#include "server/fem/model.h"
#include "server/fem/skew_correction.h"
#include "server/fem/tangent_matrix.h"
#include "server/mesh/vertex_field.h"

namespace kerf::fem {

struct EquilibriumOptions {
  double tolerance = 1e-9;   // -, see EquilibriumStats::residual
  int max_iterations = 300;  // Newton steps, >= 1
};

struct EquilibriumStats {
  bool converged = false;  // residual <= tolerance
  // -, Euclidean norm of the forces that are not in balance, over that of the loads and the reactions; where there are
  // neither, over what rounding leaves.
  double residual = 0.0;
  int iterations = 0;  // Newton steps
  double shift = 0.0;  // 1/s^2, times the masses, added to the stiffness in the last step; 0: it was positive definite
                       // by itself, so that the equilibrium is stable
};

// Where a sheet is at rest under constant loads: a local minimum of elastic energy minus the work of the loads, by
// Newton's method with the exact tangent. Where that is not positive definite (a free or slack sheet, buckling) masses
// are added until it is, as many as needed: a step of a body that slides downhill without inertia. Steps are cut back
// until the energy falls, so that it never rises. Wind and the velocities of pins and grabs are left out.
class EquilibriumSolver {
 public:
  explicit EquilibriumSolver(const EquilibriumOptions& options);

  // Before the first solve() and after each change of the model.
  void rebuild(const Model& model);

  // x (3 x V, m): where to start, but for pins, which are put at their targets first; becomes the equilibrium, or the
  // best that was found. `watch`, where given, is called after each iteration and ends the search by returning false.
  using Watch = std::function<bool(const EquilibriumStats&)>;
  EquilibriumStats solve(const Model& model, const Loads& loads, const Watch& watch, mesh::VertexField& x);

 private:
  // Into residual_, which is 0 where pins hold; returns its norm over the scale.
  double evaluate(const Model& model, const Loads& loads, const mesh::VertexField& x);
  [[nodiscard]] double energy(const Model& model, const Loads& loads, const mesh::VertexField& x,
                              const mesh::VertexField& origin) const;
  // Into step_, with more and more masses until the matrix is positive definite. False: it never was.
  bool find_step(const Model& model, const Loads& loads, const mesh::VertexField& x, EquilibriumStats& stats);
  // The same with what of the tangent is not symmetric.
  void correct_step(const Model& model, const Loads& loads, const mesh::VertexField& x);
  enum class Progress { kNone, kBlind, kDescended };
  // Moves x along step_, if anything is gained that way.
  Progress search_line(const Model& model, const Loads& loads, EquilibriumStats& stats, mesh::VertexField& x);

  EquilibriumOptions options_;
  BlockCholesky solver_;
  SkewCorrection correction_;
  TangentMatrix matrix_;
  TangentMatrix skew_;                                              // where there are follower loads
  mesh::VertexField force_, residual_, rhs_, step_, trial_, best_;  // 3 x V
};

}  // namespace kerf::fem
