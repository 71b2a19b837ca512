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
// Implicit Euler, the trapezoidal rule and BDF2 are this with their own base and d.
struct Stage {
  State base;
  // kg m/s, of base.v without what internal forces have put into it, which is nothing but their rounding.
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  double d = 0.0;               // s, > 0
  mesh::VertexField ballistic;  // m, where the stage ends under gravity alone: where the search begins
  double time_left = 0.0;       // s, from the end of the stage to the end of the step, for moving pins and grabs
  // Whether the last solve() was of the stage before, in the same step: what it predicted of the stress then serves the
  // first iteration, where that at its end, being of a few linear steps, may have false stretch.
  bool continues = false;
  bool may_repair = true;  // or is to be given up where the fast iteration fails
  const ContactConstraint* contact = nullptr;
  const mesh::VertexField* start = nullptr;  // m, positions when the substep began; needed where there is contact
};

// Solves a stage by Newton's method, each linear system made positive definite (see MembraneTangent::stiffness).
//
// Fast iteration: full steps, and in the tangent, not in the residual, the stress predicted by the linear step before
// (mixed integration points, Magisano, Leonetti, Garcea 2017): the true stress of a stiff sheet after a linear step is
// mostly the false stretch of its rotation. Its best point is taken where that converged, or lowers the incremental
// potential and, with contact, came near; else it is thrown away for projected Newton steps with backtracking on the
// potential, without stiffness damping: they always descend, so a step can never blow up.
class StageSolver {
 public:
  explicit StageSolver(const IntegratorOptions& options);

  void rebuild(const Model& model);
  // The same where the last Model::follow is all that has changed since the call before.
  void follow(const Model& model);
  // The pattern is analysed where follow() changed it.
  void prepare();
  // What the stages so far left in the linear solver is to have no influence on those to come.
  void forget() { solver_->forget(); }
  // See Integrator::heed; what ends early has found no solution.
  void heed(const GoesOn* goes_on);
  // constant_force: 3 x V, N. state.x: where to start from; becomes the solution, state.v its velocity. False: no
  // finite solution was found, state is then undefined. Adds to the counters of stats, its flags and residual.
  bool solve(const Model& model, const Loads& loads, const mesh::VertexField& constant_force, const Stage& stage,
             State& state, StepStats& stats);

  // Whether solve_majorized() holds what it promises: of co-rotational sheets that are flat at rest and without loads
  // that follow them. Contact it leaves out.
  [[nodiscard]] static bool can_majorize(const Model& model, const Loads& loads);
  // The stage of implicit Euler from stage.base, in one linear solve, with the membrane's energy bounded from above
  // there (see MajorizedTriangle) and without stiffness damping: the step gains no energy, however far it goes. As of
  // solve(), but for state.x before.
  bool solve_majorized(const Model& model, const Loads& loads, const mesh::VertexField& constant_force,
                       const Stage& stage, State& state, StepStats& stats);

 private:
  // What stays the same during one solve.
  struct Problem {
    const Model& model;
    const Loads& loads;
    const mesh::VertexField& constant_force;
    const Stage& stage;
    std::span<const double> beta;  // stiffness damping, see damping_of; none in a repair
    bool is_majorized = false;     // the membrane, at the x that is asked for
  };
  // Makes room for the model, once its matrix is there.
  void resize(const Model& model);

  // What follows a solution: momentum restored, velocities.
  void finish(const Problem& problem, State& state) const;

  bool iterate(const Problem& problem, mesh::VertexField& x, StepStats& stats);
  // Whether `x`, where the iteration did not converge, is no higher in the potential than where it began.
  bool accept(const Problem& problem, const mesh::VertexField& x, double residual, StepStats& stats) const;
  // The first Newton step, into step_; returns the scale of the residual (see IntegratorOptions::newton_tolerance).
  double solve_first(const Problem& problem, const mesh::VertexField& x, StepStats& stats);
  bool repair(const Problem& problem, const mesh::VertexField& start, mesh::VertexField& x, StepStats& stats);
  bool search_line(const Problem& problem, double merit, mesh::VertexField& x);

  // Whether nothing holds the sheet or is touched by it.
  [[nodiscard]] bool is_free(const Problem& problem) const;
  // Moves the whole of a free sheet so that its residual has no resultant: internal forces have none, so linear
  // momentum is conserved to round-off however loosely the stage was solved.
  void restore_momentum(const Problem& problem, mesh::VertexField& x) const;

  // Into residual_, zero at pins; returns its Euclidean norm. Without contact forces.
  double evaluate_residual(const Problem& problem, const mesh::VertexField& x);
  // The same with them.
  double evaluate_residual(const Problem& problem, const mesh::VertexField& x, StageContact::Update update);
  // The same over `scale`; what would pull lets go once it has settled.
  double evaluate_relative(const Problem& problem, const mesh::VertexField& x, double scale);
  void add_grab_forces(const Problem& problem, const mesh::VertexField& x);
  // The incremental potential whose negative gradient the residual is where beta is 0, kg m^2. Follower loads have
  // none: their work from `origin` to `x` stands for it, so that only values of the same origin can be compared.
  [[nodiscard]] double merit(const Problem& problem, const mesh::VertexField& x, const mesh::VertexField& origin) const;

  // Into matrix_. With stress_ where `predicted`, else with the stress at x.
  void assemble(const Problem& problem, const mesh::VertexField& x, bool predicted);
  // See TangentMatrix::constrain; into step_ and rhs_.
  void constrain(const Problem& problem, const mesh::VertexField& x);
  // A Newton step that is not the first, into step_.
  void solve_next(const Problem& problem, const mesh::VertexField& x, bool predicted, StepStats& stats);
  // After solve_linear(): whether it is worth trying without the tangent of follower loads, which alone can keep the
  // matrix from being positive definite. They stay in the residual; it is left out until the stage is solved.
  bool leave_out_loads();
  // matrix_ x = rhs_, x holding the guess; leaves in is_solved_ whether it was found.
  void solve_linear(LinearSolver& solver, StepStats& stats, mesh::VertexField& x);

  IntegratorOptions options_;
  Heed heed_;
  std::unique_ptr<LinearSolver> solver_;
  std::unique_ptr<LinearSolver> repair_solver_;  // where solver_ solves a different system: its steps may not descend
  StageContact contact_;
  TangentMatrix matrix_;
  bool is_analysed_ = false;    // matrix_ by the linear solvers, as its pattern is now
  bool follows_loads_ = false;  // whether matrix_ has the tangent of follower loads
  bool is_solved_ = true;
  bool is_predicted_ = false;                                    // stress_ belongs to the solution of the last stage
  std::vector<Eigen::Vector3d> stress_;                          // one a lane, N/m, for the tangent
  mesh::VertexField force_, residual_, rhs_, step_, increment_;  // 3 x V
  mesh::VertexField velocity_, damped_, trial_, start_, best_;
};

}  // namespace kerf::fem
