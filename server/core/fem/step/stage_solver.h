#pragma once

#include <memory>
#include <span>
#include <vector>

#include "server/core/fem/element/membrane_tangent.h"
#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/fem/step/stage_contact.h"
#include "server/core/linear/linear_solver.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// One implicit stage: x = base.x + d v with M v = M base.v + d (f(x, v) + constant force + M g - alpha M v), hence
//   M (1 + d alpha) (x - base.x) - d M base.v - d^2 (f(x, v) + constant force + M g) = 0.
// Implicit Euler, the trapezoidal rule and BDF2 are stages with their own base and d.
struct Stage {
  State base;
  // kg m/s, momentum of base.v without the contribution of internal forces, which is only their rounding.
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  double d = 0.0;               // s, > 0
  mesh::VertexField ballistic;  // m, end of the stage under gravity alone, where the search begins
  double time_left = 0.0;       // s, from the end of the stage to the end of the step, for moving pins and grabs
  // True if the last solve() was of the previous stage of the same step. The stress it predicted then serves the first
  // iteration. The stress at its end may contain false stretch, after only a few linear steps.
  bool continues = false;
  bool may_repair = true;  // false: the stage fails if the fast iteration fails
  const ContactConstraint* contact = nullptr;
  const mesh::VertexField* start = nullptr;  // m, positions when the substep began; required with contact
};

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
  void forget() { solver_->forget(); }
  // Sets the stop condition, see Integrator::heed. A stopped solve has found no solution.
  void heed(const GoesOn* goes_on);
  // Solves a stage. constant_force: 3 x V, N. state.x holds the start and becomes the solution, state.v its velocity.
  // Returns false, with undefined state, if no finite solution was found. Adds to the counters, flags and residual of
  // stats.
  bool solve(const Model& model, const Loads& loads, const mesh::VertexField& constant_force, const Stage& stage,
             State& state, StepStats& stats);

  // Returns true if solve_majorized() applies: to co-rotational sheets that are flat at rest, without bending by angles
  // and without follower loads. It must be called without contact.
  [[nodiscard]] static bool can_majorize(const Model& model, const Loads& loads);
  // Solves the implicit Euler stage from stage.base in one linear solve, ignoring state.x. The membrane's energy is
  // bounded from above there (see MajorizedTriangle), and stiffness damping is left out. The step gains no energy,
  // however far it goes. Otherwise as solve().
  bool solve_majorized(const Model& model, const Loads& loads, const mesh::VertexField& constant_force,
                       const Stage& stage, State& state, StepStats& stats);

 private:
  // Constants of one solve.
  struct Problem {
    const Model& model;
    const Loads& loads;
    const mesh::VertexField& constant_force;
    const Stage& stage;
    std::span<const double> beta;  // stiffness damping, see damping_of; none in a repair
    bool is_majorized = false;     // uses the majorised membrane, bounded at the given x
  };
  // Resizes all fields for the model, whose matrix must be built.
  void resize(const Model& model);

  // Finishes a solution: restores momentum and sets velocities.
  void finish(const Problem& problem, State& state) const;

  bool iterate(const Problem& problem, mesh::VertexField& x, StepStats& stats);
  // Returns true if `x`, where the iteration stopped without convergence, is no higher in the potential than its start.
  bool accept(const Problem& problem, const mesh::VertexField& x, double residual, StepStats& stats) const;
  // Computes the first Newton step in step_. Returns the scale of the residual (see
  // IntegratorOptions::newton_tolerance).
  double solve_first(const Problem& problem, const mesh::VertexField& x, StepStats& stats);
  bool repair(const Problem& problem, const mesh::VertexField& start, mesh::VertexField& x, StepStats& stats);
  bool search_line(const Problem& problem, double merit, mesh::VertexField& x);

  // Returns true if the sheet has no pins, grabs or contacts.
  [[nodiscard]] bool is_free(const Problem& problem) const;
  // Translates a free sheet so that its residual has no resultant. Internal forces have none, so linear momentum is
  // conserved to round-off however loosely the stage was solved.
  void restore_momentum(const Problem& problem, mesh::VertexField& x) const;

  // Sets residual_, zero at pins, without contact forces. Returns its Euclidean norm.
  double evaluate_residual(const Problem& problem, const mesh::VertexField& x);
  // Sets residual_ with contact forces and returns its norm.
  double evaluate_residual(const Problem& problem, const mesh::VertexField& x, StageContact::Update update);
  // Returns the norm with contact forces over `scale`. Contacts that would pull let go once the residual has settled.
  double evaluate_relative(const Problem& problem, const mesh::VertexField& x, double scale);
  void add_grab_forces(const Problem& problem, const mesh::VertexField& x);
  // Returns the incremental potential, kg m^2, whose negative gradient is the residual if beta is 0. Follower loads
  // have no potential: their work from `origin` to `x` replaces it, so only values of the same origin can be compared.
  [[nodiscard]] double merit(const Problem& problem, const mesh::VertexField& x, const mesh::VertexField& origin) const;

  // Assembles matrix_, with stress_ if `predicted`, otherwise with the stress at x.
  void assemble(const Problem& problem, const mesh::VertexField& x, bool predicted);
  // Applies TangentMatrix::constrain to step_ and rhs_.
  void constrain(const Problem& problem, const mesh::VertexField& x);
  // Computes a later Newton step in step_.
  void solve_next(const Problem& problem, const mesh::VertexField& x, bool predicted, StepStats& stats);
  // Call after solve_linear(). Returns true if the solve should be repeated without the tangent of follower loads,
  // which alone can keep the matrix from being positive definite. They stay in the residual. The tangent is left out
  // until the stage is solved.
  bool leave_out_loads();
  // Solves matrix_ x = rhs_ from the guess x. Sets is_solved_ to whether it converged.
  void solve_linear(LinearSolver& solver, StepStats& stats, mesh::VertexField& x);

  IntegratorOptions options_;
  Heed heed_;
  std::unique_ptr<LinearSolver> solver_;
  std::unique_ptr<LinearSolver> repair_solver_;  // used if solver_ solves a different system, whose steps may not
                                                 // descend
  StageContact contact_;
  TangentMatrix matrix_;
  bool is_analysed_ = false;    // the linear solvers have analysed the present pattern of matrix_
  bool follows_loads_ = false;  // matrix_ includes the tangent of follower loads
  bool is_solved_ = true;
  bool is_predicted_ = false;                                    // stress_ belongs to the solution of the last stage
  std::vector<Eigen::Vector3d> stress_;                          // one a lane, N/m, for the tangent
  mesh::VertexField force_, residual_, rhs_, step_, increment_;  // 3 x V
  mesh::VertexField velocity_, damped_, trial_, start_, best_;
};

}  // namespace kerf::fem
