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
// mostly the false stretch of its rotation. The best point is accepted if it converged, or if it lowers the incremental
// potential and, with contact, came near. Otherwise it is discarded.
//
// Repair: projected Newton steps with backtracking on the potential, without stiffness damping. They always descend, so
// a step can never blow up.
class StageSolver {
 public:
  explicit StageSolver(const IntegratorOptions& options);

  void rebuild(const Model& model);
  // Updates after exactly one Model::follow since the previous call.
  void follow(const Model& model);
  // Analyses the pattern if follow() changed it.
  void prepare();
  // Discards the data of earlier stages in the linear solver, so that they have no influence on later ones.
  void reset() { solver_->reset(); }
  // Sets the stop condition, see Integrator::set_stop_condition. A stopped solve has found no solution.
  void set_stop_condition(const StopCondition* stop);
  // Solves a stage. constant_force: 3 x V, N. state.x holds the start and becomes the solution, state.v its velocity.
  // Returns false, with undefined state, if no finite solution was found. Adds to the counters, flags and residual of
  // stats.
  bool solve(const Model& model, const Loads& loads, const linear::VertexField& constant_force, const Stage& stage,
             State& state, StepStats& stats);

  // Returns true if solve_majorized() applies: to co-rotational sheets that are flat at rest, without bending by angles
  // and without follower loads. It must be called without contact.
  [[nodiscard]] static bool can_majorize(const Model& model, const Loads& loads);
  // Solves the implicit Euler stage from stage.base in one linear solve, ignoring state.x. The membrane's energy is
  // bounded from above there (see MajorizedTriangle), and stiffness damping is left out. The step gains no energy,
  // however far it goes. Otherwise as solve().
  bool solve_majorized(const Model& model, const Loads& loads, const linear::VertexField& constant_force,
                       const Stage& stage, State& state, StepStats& stats);

 private:
  enum class Phase {
    kPatternChanged,  // prepare() must analyse the pattern of matrix_
    kReady,
    kPredicted,  // ready, and stress_ belongs to the solution of the last stage
  };
  // Resizes all fields for the model, whose matrix must be built.
  void resize(const Model& model);

  // Finishes a solution: restores momentum and sets velocities.
  void finish(const StageProblem& problem, State& state) const;

  bool iterate(StageProblem& problem, linear::VertexField& x, StepStats& stats);
  // Returns true if `x`, where the iteration stopped without convergence, is no higher in the potential than its start.
  bool accept(const StageProblem& problem, const linear::VertexField& x, double residual, StepStats& stats) const;
  // Computes the first Newton step in step_. Returns the scale of the residual (see
  // IntegratorOptions::newton_tolerance).
  double solve_first(StageProblem& problem, const linear::VertexField& x, StepStats& stats);
  bool repair(StageProblem& problem, const linear::VertexField& start, linear::VertexField& x, StepStats& stats);
  bool search_line(const StageProblem& problem, double merit, linear::VertexField& x);

  // Returns true if the sheet has no pins, grabs or contacts.
  [[nodiscard]] bool is_free(const StageProblem& problem) const;
  // Sets residual_ with contact forces and returns its norm.
  double evaluate_residual(const StageProblem& problem, const linear::VertexField& x, StageContact::Update update);
  // Returns the norm with contact forces over `scale`. Contacts that would pull let go once the residual has settled.
  double evaluate_relative(const StageProblem& problem, const linear::VertexField& x, double scale);
  // Returns the incremental potential, including the potential of the contacts found last.
  [[nodiscard]] double merit(const StageProblem& problem, const linear::VertexField& x,
                             const linear::VertexField& origin) const;

  // Assembles matrix_, with stress_ if `predicted`, otherwise with the stress at x.
  void assemble(const StageProblem& problem, const linear::VertexField& x, bool predicted);
  // Applies TangentMatrix::constrain to step_ and rhs_.
  void constrain(const StageProblem& problem, const linear::VertexField& x);
  // Computes a later Newton step in step_.
  void solve_next(StageProblem& problem, const linear::VertexField& x, bool predicted, StepStats& stats);
  // Solves matrix_ x = rhs_ from the guess x. Returns false if it should be assembled and solved again without the
  // tangent of follower loads. That tangent alone can keep the matrix from being positive definite. The loads stay in
  // the residual. Their tangent is left out until the stage is solved.
  bool solve_linear(linear::LinearSolver& solver, StageProblem& problem, StepStats& stats, linear::VertexField& x);

  IntegratorOptions options_;
  StopPoll stop_;
  std::unique_ptr<linear::LinearSolver> solver_;
  std::unique_ptr<linear::LinearSolver> repair_solver_;  // used if solver_ solves a different system, whose steps may
                                                         // not descend
  StageContact contact_;
  TangentMatrix matrix_;
  StageResidual equation_;
  Phase phase_ = Phase::kPatternChanged;
  std::vector<Eigen::Vector3d> stress_;                    // one a lane, N/m, for the tangent
  linear::VertexField residual_, rhs_, step_, increment_;  // 3 x V
  linear::VertexField trial_, start_, best_;
};

}  // namespace kerf::fem
