#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/fem/statics/equilibrium_options.h"
#include "server/core/linear/direct_solver.h"
#include "server/core/linear/skew_correction.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

class Model;
struct Loads;

// Finds the rest state of a sheet under constant loads: a local minimum of elastic energy minus the work of the loads.
// It uses Newton's method with the exact tangent, including the skew part of follower loads. If the tangent is not
// positive definite (a free sheet, buckling), a multiple of the masses, the shift, is added to it. Each step is then an
// implicit step of a sheet that slides downhill without inertia (the proximal point method). If that takes too large a
// shift, as for a slack or crushed sheet, the projected tangent is used (see MembraneTangent::stiffness).
//
// A linear step turns parts of the sheet, and a turn made linearly stretches them. In a sheet that resists stretching
// the energy then rises however good the step is. Backtracking until it falls would leave tiny steps. Hence the
// watchdog technique (Chamberlain, Powell, Lemarechal, Pedersen 1982): up to six full steps are tried. Their tangents
// have the stress, and the moments at folds, predicted by the previous linear step (mixed integration points; see
// StageSolver). They are accepted together as soon as the energy is below that before the first of them. If that never
// happens they are discarded. One step with the true stress replaces them, with backtracking until the energy falls. So
// the energy never rises, up to rounding, from one call of `watch` to the next. Bending by any angle takes some five
// steps.
//
// Wind and the velocities of pins and grabs are ignored.
class EquilibriumSolver {
 public:
  explicit EquilibriumSolver(const EquilibriumOptions& options);

  // Must be called before the first solve() and after each change of the model.
  void rebuild(const Model& model);

  // Solves for x (3 x V, m), from its initial value with pins moved to their targets. x becomes the equilibrium, or the
  // best state found. `watch` may be empty.
  EquilibriumStats solve(const Model& model, const Loads& loads, const EquilibriumWatch& watch, linear::VertexField& x);

 private:
  // Sets residual_ to the unbalanced forces at x, 0 in held components. Returns EquilibriumStats::residual.
  double evaluate(const Model& model, const Loads& loads, const linear::VertexField& x);
  [[nodiscard]] double energy(const Model& model, const Loads& loads, const linear::VertexField& x,
                              const linear::VertexField& origin) const;
  // Returns the rounding error (J) of a difference of two energies, where `energy` is that at x.
  [[nodiscard]] static double rounding(const Model& model, const linear::VertexField& x, double energy);
  // Sets stress_ and moments_ to the stress and the moments at folds after step_ from x, to first order.
  void predict(const Model& model, const linear::VertexField& x);
  // Assembles the linear system of a step, matrix_ and rhs_. Uses stress_ and moments_ if `predicted`, or those at x if
  // not. Adds `shift` (1/s^2) times the masses.
  void assemble(const Model& model, const Loads& loads, const linear::VertexField& x, bool predicted, bool project,
                double shift);
  // Computes step_, with a shift that makes the matrix positive definite. For `predicted` see assemble(). Returns false
  // if no shift made it positive definite.
  bool find_step(const Model& model, const Loads& loads, const linear::VertexField& x, bool predicted,
                 EquilibriumStats& stats);
  [[nodiscard]] bool is_stable(const Model& model, const Loads& loads, const linear::VertexField& x);
  // Corrects step_ for the skew part of the tangent.
  void correct_step(const Model& model, const Loads& loads, const linear::VertexField& x);
  enum class Progress { kNone, kNonMonotone, kDescended };
  // Tries full steps with predicted stress from x on (watchdog), until the energy is below that at x. Returns kNone,
  // with x unchanged, if it never is. Returns kNonMonotone if rounding hides whether the energy falls.
  Progress try_watchdog_steps(const Model& model, const Loads& loads, EquilibriumStats& stats, linear::VertexField& x);
  // Adds the proximal term at x to residual_. The tried steps seek the minimum of the energy plus used_shift_ / 2
  // |watchdog_x_ - x|^2, in the norm of the masses.
  void add_proximal_term(const Model& model, const linear::VertexField& x);
  // Doubles step_ from x on as long as the energy falls. `reached` is the energy after the step. It falls further where
  // it is not convex along the step.
  void lengthen_step(const Model& model, const Loads& loads, double reached, const linear::VertexField& x,
                     EquilibriumStats& stats);
  // Moves x along step_ by backtracking. Returns kNone if no part of the step lowers the energy.
  Progress search_line(const Model& model, const Loads& loads, EquilibriumStats& stats, linear::VertexField& x);

  EquilibriumOptions options_;
  linear::DirectSolver solver_;
  linear::SkewCorrection correction_;
  TangentMatrix matrix_;
  bool projects_ = false;                // the last step needed the projected tangent
  double used_shift_ = 0.0;              // 1/s^2, in the last step
  double unbalanced_ = 0.0;              // -, residual of the last evaluate(), relative to loads and reactions alone
  TangentMatrix skew_;                   // used with follower loads
  std::vector<Eigen::Vector3d> stress_;  // one a lane, N/m, for the tangent
  std::vector<double> moments_;          // J, one a fold of bending by angles, for the tangent
  linear::VertexField force_, residual_, rhs_, step_, trial_, watchdog_x_, best_;  // 3 x V
};

}  // namespace kerf::fem
