#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/linear/direct_solver.h"
#include "server/core/linear/skew_correction.h"
#include "server/core/linear/vertex_field.h"

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
  double shift = 0.0;  // 1/s^2, times the masses, added to the stiffness in the last step; 0: it is positive definite
                       // by itself there, so that an equilibrium is stable; there, up to 1e-12 of the largest
                       // eigenvalue, so that free motions, of the whole sheet or a part, count as neutral
};

// Where a sheet is at rest under constant loads: a local minimum of elastic energy minus the work of the loads, by
// Newton's method with the exact tangent, that of follower loads with its skew part included. Where it is not positive
// definite (a free sheet, buckling) masses are added, as many as needed, so that each step is one of a body that slides
// downhill without inertia, implicitly in time (the proximal point method); where that takes too many, as of a slack or
// crushed sheet, a projected tangent (see MembraneTangent::stiffness) takes its place.
//
// A linear step of a sheet that hardly stretches turns it, and a turn made linearly stretches it, so that its energy
// rises however good the step is, and steps cut back until it falls are tiny. Hence the watchdog technique
// (Chamberlain, Powell, Lemarechal, Pedersen 1982): up to six full steps, in which the tangent has the stress, and the
// moments at folds, that the linear step before predicted (mixed integration points; see StageSolver), are taken as one
// as soon as the energy is below that at its beginning; else they are forgotten, for one step with the true stress, cut
// back until the energy falls. So it never rises, up to rounding, from one call of `watch` to the next. Bending by any
// angle takes some five steps.
//
// Wind and the velocities of pins and grabs are left out.
class EquilibriumSolver {
 public:
  explicit EquilibriumSolver(const EquilibriumOptions& options);

  // Before the first solve() and after each change of the model.
  void rebuild(const Model& model);

  // x (3 x V, m): where to start, but for pins, which are put at their targets first; becomes the equilibrium, or the
  // best that was found. `watch`, where given, is called whenever x has moved and ends the search by returning false.
  using Watch = std::function<bool(const EquilibriumStats&)>;
  EquilibriumStats solve(const Model& model, const Loads& loads, const Watch& watch, mesh::VertexField& x);

 private:
  // Into residual_, which is 0 where pins hold; returns its norm over the scale.
  double evaluate(const Model& model, const Loads& loads, const mesh::VertexField& x);
  [[nodiscard]] double energy(const Model& model, const Loads& loads, const mesh::VertexField& x,
                              const mesh::VertexField& origin) const;
  // J, what it leaves of a difference between `energy`, that at x, and another.
  [[nodiscard]] static double rounding(const Model& model, const mesh::VertexField& x, double energy);
  // Into stress_ and moments_, as step_ from x would change them to first order.
  void predict(const Model& model, const mesh::VertexField& x);
  // The linear system of a step: matrix_, rhs_.
  void assemble(const Model& model, const Loads& loads, const mesh::VertexField& x, bool predicted, bool project,
                double shift);
  // Into step_, with more and more masses until the matrix is positive definite, and with stress_ where `predicted`,
  // else the stress at x. False: it never was.
  bool find_step(const Model& model, const Loads& loads, const mesh::VertexField& x, bool predicted,
                 EquilibriumStats& stats);
  [[nodiscard]] bool is_stable(const Model& model, const Loads& loads, const mesh::VertexField& x);
  // The same with what of the tangent is not symmetric.
  void correct_step(const Model& model, const Loads& loads, const mesh::VertexField& x);
  enum class Progress { kNone, kBlind, kDescended };
  // Full steps with predicted stress from x on, until the energy is below that at x, or not at all.
  Progress venture(const Model& model, const Loads& loads, EquilibriumStats& stats, mesh::VertexField& x);
  // Adds to residual_ what holds venture_ back at x: what a venture seeks is the least of the energy and
  // used_shift_ / 2 |venture_ - x|^2, in the measure of masses.
  void hold_back(const Model& model, const mesh::VertexField& x);
  // Doubles step_ from x on as long as the energy, which was `reached`, falls: where it is not convex along the step.
  void lengthen_step(const Model& model, const Loads& loads, double reached, const mesh::VertexField& x,
                     EquilibriumStats& stats);
  // Moves x along step_, if anything is gained that way.
  Progress search_line(const Model& model, const Loads& loads, EquilibriumStats& stats, mesh::VertexField& x);

  EquilibriumOptions options_;
  DirectSolver solver_;
  SkewCorrection correction_;
  TangentMatrix matrix_;
  bool projects_ = false;                // the last step needed the projected tangent
  double used_shift_ = 0.0;              // 1/s^2, in the last step
  double unbalanced_ = 0.0;              // -, of the last evaluate(), over loads and reactions alone
  TangentMatrix skew_;                   // where there are follower loads
  std::vector<Eigen::Vector3d> stress_;  // one a lane, N/m, for the tangent
  std::vector<double> moments_;          // J, one a fold of bending by angles, likewise
  mesh::VertexField force_, residual_, rhs_, step_, trial_, venture_, best_;  // 3 x V
};

}  // namespace kerf::fem
