#pragma once

#include <array>
#include <memory>
#include <vector>

#include "server/fem/block_matrix.h"
#include "server/fem/integrator.h"
#include "server/fem/linear_solver.h"
#include "server/fem/membrane_tangent.h"
#include "server/fem/stage_contact.h"

namespace kerf::fem {

// One implicit stage: x = base.x + d v with M v = M base.v + d (f(x, v) + constant force + M g - alpha M v), hence
//   M (1 + d alpha) (x - base.x) - d M base.v - d^2 (f(x, v) + constant force + M g) = 0.
// Implicit Euler, the trapezoidal rule and BDF2 are this with their own base and d.
struct Stage {
  State base;
  double d = 0.0;          // s, > 0
  double time_left = 0.0;  // s, from the end of the stage to the end of the step, for moving pins and grabs
  const ContactConstraint* contact = nullptr;
  const Eigen::Matrix3Xd* start = nullptr;  // m, positions when the substep began; needed where there is contact
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
  // constant_force: 3 x V, N. state.x: where to start from; becomes the solution, state.v its velocity. False: no
  // finite solution was found, state is then undefined. Adds to the counters of stats, its flags and residual.
  bool solve(const Model& model, const Loads& loads, const Eigen::Matrix3Xd& constant_force, const Stage& stage,
             State& state, StepStats& stats);

 private:
  // What stays the same during one solve.
  struct Problem {
    const Model& model;
    const Loads& loads;
    const Eigen::Matrix3Xd& constant_force;
    const Stage& stage;
    double beta;  // s, stiffness damping; 0 in a repair
  };
  using BlockPositions = std::array<int, 9>;  // of corner pair (i, j): entry 3 i + j

  bool iterate(const Problem& problem, Eigen::Matrix3Xd& x, StepStats& stats);
  // Whether `x`, where the iteration did not converge, is no higher in the potential than where it began.
  bool accept(const Problem& problem, const Eigen::Matrix3Xd& x, double residual, StepStats& stats) const;
  // The first Newton step, into step_; returns the scale of the residual (see IntegratorOptions::newton_tolerance).
  double solve_first(const Problem& problem, const Eigen::Matrix3Xd& x, StepStats& stats);
  bool repair(const Problem& problem, const Eigen::Matrix3Xd& start, Eigen::Matrix3Xd& x, StepStats& stats);
  bool search_line(const Problem& problem, double merit, Eigen::Matrix3Xd& x);

  // Moves the whole of a free sheet so that its residual has no resultant: internal forces have none, so linear
  // momentum is conserved to round-off however loosely the stage was solved.
  void restore_momentum(const Problem& problem, Eigen::Matrix3Xd& x) const;

  // Into residual_, zero at pins; returns its Euclidean norm. Without contact forces.
  double evaluate_residual(const Problem& problem, const Eigen::Matrix3Xd& x);
  // The same with them.
  double evaluate_residual(const Problem& problem, const Eigen::Matrix3Xd& x, StageContact::Update update);
  // The same over `scale`; what would pull lets go once it has settled.
  double evaluate_relative(const Problem& problem, const Eigen::Matrix3Xd& x, double scale);
  void add_grab_forces(const Problem& problem, const Eigen::Matrix3Xd& x);
  // The incremental potential whose negative gradient the residual is where beta is 0, kg m^2.
  [[nodiscard]] double merit(const Problem& problem, const Eigen::Matrix3Xd& x) const;

  // Into matrix_. With stress_ where `predicted`, else with the stress at x.
  void assemble(const Problem& problem, const Eigen::Matrix3Xd& x, bool predicted);
  void add_membrane(const Problem& problem, const Eigen::Matrix3Xd& x, bool predicted);
  void add_bending_and_grabs(const Problem& problem);
  void predict_stress(const Problem& problem, const Eigen::Matrix3Xd& x);  // from step_, into stress_
  // Puts the pins' displacement into step_ and rhs_ and decouples their rows: matrix_ stays symmetric.
  void constrain(const Problem& problem, const Eigen::Matrix3Xd& x);
  // matrix_ x = rhs_, x holding the guess.
  void solve_linear(StepStats& stats, Eigen::Matrix3Xd& x);

  IntegratorOptions options_;
  std::unique_ptr<LinearSolver> solver_;
  StageContact contact_;
  BlockMatrix matrix_;
  std::vector<BlockPositions> positions_;                       // one a lane of the model's blocks
  std::vector<Eigen::Vector3d> stress_;                         // one a lane, N/m, for the tangent
  Eigen::Matrix3Xd force_, residual_, rhs_, step_, increment_;  // 3 x V
  Eigen::Matrix3Xd velocity_, damped_, trial_, start_, best_;
};

}  // namespace kerf::fem
