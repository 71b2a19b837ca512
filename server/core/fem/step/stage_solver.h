#pragma once

#include <memory>
#include <span>
#include <vector>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/membrane_tangent.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/fem/step/stage_contact.h"
#include "server/core/fem/step/stage_equation.h"
#include "server/core/linear/linear_solver.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Solves a stage by Newton's method, with each linear system made positive definite (see MembraneTangent::stiffness).
//
// Fast iteration: full steps. The tangent, but not the residual, uses the stress predicted by the previous linear step
// (mixed integration points, Magisano, Leonetti, Garcea 2017). The true stress of a stiff sheet after a linear step is
// mostly false stretch: a rotation made linearly stretches the sheet. The iterate with the least residual is accepted
// if it has converged. It is also accepted if it lowers the incremental potential; with contact its residual must be
// small as well. In all other cases the iteration has failed.
//
// Repair, if the fast iteration has failed: projected Newton steps with backtracking on the incremental potential,
// without stiffness damping. They always descend, so a step can never blow up.
class StageSolver {
 public:
  explicit StageSolver(const IntegratorOptions& options);

  void rebuild(const Model& model);
  // Updates after exactly one Model::follow since the previous call.
  void follow(const Model& model);
  // Lets the linear solver analyse the pattern of the matrix if follow() changed it.
  void prepare();
  // Discards the data of earlier stages in the linear solver, so that they have no influence on later ones.
  void reset() { solver_->reset(); }
  // Sets the stop condition, see Integrator::set_stop_condition. A stopped solve has found no solution.
  void set_stop_condition(const StopCondition* stop);
  // Solves a stage. constant_force: 3 x V, N. state.x holds the start of the search and becomes the solution; state.v
  // becomes its velocity. Returns false, with undefined state, if no finite solution was found. Adds to the counters
  // and flags of stats, and raises its residuals.
  bool solve(const Model& model, const Loads& loads, const linear::VertexField& constant_force, const Stage& stage,
             State& state, StepStats& stats);

  // Calls StageContact::stop() with the contacts of the last solve().
  void stop_in_contact(linear::VertexField& v) const { contact_.stop(v); }

  // Returns true if solve_majorized() applies: to co-rotational sheets that are flat at rest, without bending by angles
  // and without follower loads. It must be called without contact.
  [[nodiscard]] static bool can_majorize(const Model& model, const Loads& loads);
  // Solves the implicit Euler stage from stage.base in one linear solve, ignoring state.x. The membrane's energy is
  // bounded from above there (see MajorizedTriangle), and stiffness damping is left out. The step gains no energy,
  // however far it goes. Arguments and result are those of solve().
  bool solve_majorized(const Model& model, const Loads& loads, const linear::VertexField& constant_force,
                       const Stage& stage, State& state, StepStats& stats);

 private:
  enum class Phase {
    kPatternChanged,  // the pattern of matrix_ changed: prepare() must be called
    kReady,
    kPredicted,  // ready, and stress_ belongs to the solution of the last stage
  };
  // Resizes all fields for the model, whose matrix must be built.
  void resize(const Model& model);

  // Finishes a solution: restores momentum and sets velocities.
  void finish(const StageProblem& problem, State& state);

  bool iterate(StageProblem& problem, linear::VertexField& x, StepStats& stats);
  // Decides whether `x`, where iterate() stopped without convergence, is taken. Returns true if its incremental
  // potential without damping is no higher than at start_.
  bool accept(const StageProblem& problem, const linear::VertexField& x, double residual, StepStats& stats) const;
  // Returns the residual at which the fast iteration has converged, over `scale`. Friction may be far smaller than all
  // other forces, and decides all the same whether a vertex slides.
  [[nodiscard]] double tolerance(const StageProblem& problem, double scale) const;
  // Makes the step step_ of the fast iteration, shortened if contact overshoots. `solution`: what the linear system
  // gave for it, m. Sets residual_ at the new `x`, without contact.
  void make_step(const StageProblem& problem, const linear::VertexField& solution, bool may_shorten,
                 linear::VertexField& x);
  // Computes the first Newton step in step_. Returns the scale of the residual (see
  // IntegratorOptions::newton_tolerance).
  double solve_first(StageProblem& problem, const linear::VertexField& x, StepStats& stats);
  bool repair(StageProblem& problem, const linear::VertexField& start, linear::VertexField& x, StepStats& stats);
  bool search_line(const StageProblem& problem, double merit, linear::VertexField& x);

  // Returns true if the sheet has no pins, grabs or contacts.
  [[nodiscard]] bool is_free(const StageProblem& problem) const;
  // Adds the contact forces at `x` to residual_. Returns its norm, with the forces that would close the gaps. Contacts
  // that would pull let go once it is small against `scale` and against the normal forces.
  double add_contact(const StageProblem& problem, double scale, const linear::VertexField& x);
  // Sets residual_ with contact forces and returns its norm.
  double evaluate_residual(const StageProblem& problem, const linear::VertexField& x);
  // Returns the incremental potential, including the potential of the contacts found last.
  [[nodiscard]] double merit(const StageProblem& problem, const linear::VertexField& x,
                             const linear::VertexField& origin) const;

  // Assembles matrix_ at x. The stress is stress_ if `predicted`, or that at x if not.
  void assemble(const StageProblem& problem, const linear::VertexField& x, bool predicted);
  // Applies TangentMatrix::constrain to step_ and rhs_.
  void constrain(const StageProblem& problem, const linear::VertexField& x);
  // Computes a later Newton step in step_.
  void solve_next(StageProblem& problem, const linear::VertexField& x, bool predicted, StepStats& stats);
  // Solves matrix_ x = rhs_ from the guess x. Returns false if matrix_ must be assembled and solved again without the
  // tangent of follower loads. Only that tangent can keep the matrix from being positive definite. It is then left out
  // until the stage is solved, while the loads stay in the residual.
  bool solve_linear(linear::LinearSolver& solver, StageProblem& problem, StepStats& stats, linear::VertexField& x);

  IntegratorOptions options_;
  StopPoll stop_;
  std::unique_ptr<linear::LinearSolver> solver_;
  double rounding_ = 0.0;  // kg m, residual that rounding leaves
  // Used for repairs if the steps of solver_ may not descend, because it solves a different system. Null if it does
  // not.
  std::unique_ptr<linear::LinearSolver> repair_solver_;
  StageContact contact_;
  TangentMatrix matrix_;
  StageResidual equation_;
  Phase phase_ = Phase::kPatternChanged;
  std::vector<Eigen::Vector3d> stress_;                    // N/m, one a lane, predicted stress for the tangent
  linear::VertexField residual_, rhs_, step_, increment_;  // 3 x V
  linear::VertexField trial_, start_, best_;
};

}  // namespace kerf::fem
