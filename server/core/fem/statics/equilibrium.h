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
// positive definite (a free sheet, buckling), as much mass as needed is added. Each step is then one of a body that
// slides downhill without inertia, implicitly in time (the proximal point method). If that takes too much mass, as for
// a slack or crushed sheet, a projected tangent (see MembraneTangent::stiffness) replaces it.
//
// A linear step of a sheet that hardly stretches turns it, and a turn made linearly stretches it. Its energy rises
// however good the step is, and backtracking until it falls leaves tiny steps. Hence the watchdog technique
// (Chamberlain, Powell, Lemarechal, Pedersen 1982): up to six full steps are tried. Their tangents have the stress, and
// the moments at folds, predicted by the previous linear step (mixed integration points; see StageSolver). They are
// accepted together as soon as the energy is below that at their beginning. Otherwise they are discarded for one step
// with the true stress, with backtracking until the energy falls. So the energy never rises, up to rounding, from one
// call of `watch` to the next. Bending by any angle takes some five steps.
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
  // Sets residual_, which is 0 in held components. Returns its norm over the scale.
  double evaluate(const Model& model, const Loads& loads, const linear::VertexField& x);
  [[nodiscard]] double energy(const Model& model, const Loads& loads, const linear::VertexField& x,
                              const linear::VertexField& origin) const;
  // Returns the rounding error (J) of differences between `energy`, that at x, and another.
  [[nodiscard]] static double rounding(const Model& model, const linear::VertexField& x, double energy);
  // Sets stress_ and moments_ to their values after step_ from x, to first order.
  void predict(const Model& model, const linear::VertexField& x);
  // Assembles the linear system of a step: matrix_, rhs_.
  void assemble(const Model& model, const Loads& loads, const linear::VertexField& x, bool predicted, bool project,
                double shift);
  // Computes step_, adding masses until the matrix is positive definite. Uses stress_ if `predicted`, otherwise the
  // stress at x. Returns false if the matrix never became positive definite.
  bool find_step(const Model& model, const Loads& loads, const linear::VertexField& x, bool predicted,
                 EquilibriumStats& stats);
  [[nodiscard]] bool is_stable(const Model& model, const Loads& loads, const linear::VertexField& x);
  // Corrects step_ for the skew part of the tangent.
  void correct_step(const Model& model, const Loads& loads, const linear::VertexField& x);
  enum class Progress { kNone, kNonMonotone, kDescended };
  // Tries full steps with predicted stress from x on (watchdog), until the energy is below that at x. Returns kNone if
  // it never is.
  Progress try_watchdog_steps(const Model& model, const Loads& loads, EquilibriumStats& stats, linear::VertexField& x);
  // Adds the proximal term at x to residual_. The tried steps seek the minimum of the energy plus used_shift_ / 2
  // |watchdog_x_ - x|^2, in the norm of the masses.
  void add_proximal_term(const Model& model, const linear::VertexField& x);
  // Doubles step_ from x on as long as the energy, which was `reached`, falls. It does so where the energy is not
  // convex along the step.
  void lengthen_step(const Model& model, const Loads& loads, double reached, const linear::VertexField& x,
                     EquilibriumStats& stats);
  // Moves x along step_, if that lowers the energy.
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
