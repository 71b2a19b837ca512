#include "server/core/fem/step/stage_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/base/check.h"
#include "server/core/fem/element/follower_loads.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/membrane_tangent.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/element/vertex_frames.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {
namespace {

constexpr int kRepairIterations = 30;
constexpr int kMaxBacktracks = 30;
constexpr int kContactIterations = 8;    // least number of Newton iterations allowed if vertices touch
constexpr int kFrictionIterations = 4;   // more of them if only the forces of friction are not resolved yet
constexpr double kSettled = 1e-2;        // -, relative residual below which contacts that would pull let go
constexpr double kSettledContact = 0.1;  // -, residual over normal forces below which they do
constexpr double kNearly = 0.1;          // -, relative residual above which an iteration with contact has failed
constexpr double kOfFriction = 0.01;     // -, largest residual over the forces of friction
constexpr double kLeastLinearTolerance = 1e-10;

double dot(const linear::VertexField& a, const linear::VertexField& b) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < a.cols(); ++i) sum += a.col(i).dot(b.col(i));
  return sum;
}

}  // namespace

StageSolver::StageSolver(const IntegratorOptions& options)
    : options_(options),
      solver_(
          linear::make_linear_solver(options.linear_solver, options.max_linear_iterations, options.covariance_root)) {
  if (!linear::name_of(options.linear_solver).solves_different_system) return;
  repair_solver_ = linear::make_linear_solver(linear::LinearSolverKind::kBlockJacobiCg, options.max_linear_iterations);
}

void StageSolver::rebuild(const Model& model) {
  matrix_.rebuild(model);
  resize(model);
  prepare();
}

void StageSolver::follow(const Model& model) {
  matrix_.follow(model);
  resize(model);
}

void StageSolver::resize(const Model& model) {
  contact_.resize(model.num_vertices());
  stress_.resize(model.element_blocks().size() * kLanes, Eigen::Vector3d::Zero());
  for (linear::VertexField* field : {&residual_, &rhs_, &step_, &increment_, &trial_, &start_, &best_}) {
    field->resize(model.num_vertices());
  }
  equation_.resize(model.num_vertices());
  phase_ = Phase::kPatternChanged;
}

void StageSolver::prepare() {
  if (phase_ != Phase::kPatternChanged) return;
  solver_->analyse(matrix_.blocks());
  if (repair_solver_) repair_solver_->analyse(matrix_.blocks());
  phase_ = Phase::kReady;
}

void StageSolver::set_stop_condition(const StopCondition* stop) {
  stop_.set(stop);
  solver_->set_stop_condition(stop);
  if (repair_solver_) repair_solver_->set_stop_condition(stop);
}

void StageSolver::assemble(const StageProblem& problem, const linear::VertexField& x, bool predicted) {
  const double d = problem.stage.d;
  const MaterialScale material_scale{d * d, d, problem.beta};
  const std::span<const Eigen::Vector3d> stress(stress_);
  if (std::vector<Eigen::Matrix3d>* const frames = solver_->frames()) {
    find_vertex_frames(problem.model.element_blocks(), x, *frames);
  }
  if (linear::VertexField* const positions = solver_->positions()) *positions = x;
  matrix_.set_mass(problem.model, 1.0, d);
  if (problem.is_majorized) {
    matrix_.add_majorized_membrane(problem.model, x, d * d);
  } else {
    matrix_.add_membrane(problem.model, x, predicted ? stress : stress.first(0), material_scale, d * d, true);
  }
  matrix_.add_bending(problem.model, material_scale);
  matrix_.add_grabs(problem.loads.grabs, d);
  if (problem.has_follower_tangent)
    matrix_.add_follower_loads(problem.model, problem.loads, x, d * d, MatrixPart::kSymmetric);
}

void StageSolver::constrain(const StageProblem& problem, const linear::VertexField& x) {
  matrix_.constrain(problem.model, problem.loads.pins, problem.stage.time_left, x, rhs_, step_);
}

// Solves one stage:
//   1. Contacts start where the substep does. start_, from which repair() begins, has pinned vertices where their pins
//      are at the end of the stage. The first tangent gets a predicted stress.
//   2. iterate() makes full Newton steps: solve_first(), then solve_next(). If they do not converge, accept() takes the
//      result if its incremental potential without damping is no higher than that of start_.
//   3. If it is not taken, and the stage may be repaired, repair() starts again with backtracking.
//   4. finish() restores momentum and sets velocities.
bool StageSolver::solve(const Model& model, const Loads& loads, const linear::VertexField& constant_force,
                        const Stage& stage, State& state, StepStats& stats) {
  KERF_CHECK(phase_ != Phase::kPatternChanged, "prepare() was called after follow()");
  StageProblem problem{model, loads, constant_force, stage, model.materials().stiffness_damping()};
  contact_.begin(stage.contact, model, stage.d, stage.start != nullptr ? *stage.start : state.x);
  problem.has_follower_tangent = has_follower_loads(loads);
  start_ = state.x;
  for (const Pin& pin : loads.pins) {
    start_.col(pin.vertex) = pin.held(pin.target - stage.time_left * pin.velocity, start_.col(pin.vertex));
  }
  if (!stage.continues || phase_ != Phase::kPredicted) {
    step_.setZero();
    predict_stress(problem.model.element_blocks(), problem.model.materials(), state.x, step_, stress_);
  }
  bool found = iterate(problem, state.x, stats);
  phase_ = found ? Phase::kPredicted : Phase::kReady;
  if (!found && stage.may_repair) {
    StageProblem undamped = problem;
    undamped.beta = {};
    found = repair(undamped, start_, state.x, stats);
  }
  if (!found || !state.x.allFinite()) return false;
  finish(problem, state);
  return true;
}

void StageSolver::finish(const StageProblem& problem, State& state) {
  if (is_free(problem)) restore_momentum(problem, state.x);
  contact_.project(state.x);
  state.v = (state.x - problem.stage.base.x) / problem.stage.d;
  contact_.stop(state.v);
  for (const Pin& pin : problem.loads.pins) state.v.col(pin.vertex) = pin.held(pin.velocity, state.v.col(pin.vertex));
}

bool StageSolver::is_free(const StageProblem& problem) const {
  return problem.loads.pins.empty() && problem.loads.grabs.empty() && !contact_.touches();
}

bool StageSolver::can_majorize(const Model& model, const Loads& loads) {
  return model.materials().membrane_law() == MembraneLaw::kCorotational &&
         model.bending().rest(model.element_blocks()).rest.empty() && model.bending().angles() == nullptr &&
         !has_follower_loads(loads);
}

bool StageSolver::solve_majorized(const Model& model, const Loads& loads, const linear::VertexField& constant_force,
                                  const Stage& stage, State& state, StepStats& stats) {
  KERF_CHECK(phase_ != Phase::kPatternChanged && can_majorize(model, loads) && stage.contact == nullptr,
             "see can_majorize()");
  const StageProblem exact{model, loads, constant_force, stage, {}};
  StageProblem problem = exact;
  problem.is_majorized = true;
  contact_.begin(nullptr, model, stage.d, stage.base.x);
  phase_ = Phase::kReady;
  state.x = stage.base.x;
  // A free sheet starts at the position given by its momentum. Moving it there after the solve could gain energy if the
  // solve stopped early. The bound and bending do not change with the translation.
  if (is_free(exact)) restore_momentum(exact, state.x);
  const double reference = equation_.evaluate(problem, state.x, residual_);
  if (!std::isfinite(reference)) return false;  // solvers that stop at once would report an unsolved state as solved
  solve_next(problem, state.x, false, stats);
  ++stats.newton_iterations;
  state.x += step_;
  if (!state.x.allFinite()) return false;
  const double residual = equation_.evaluate(exact, state.x, residual_);
  if (!std::isfinite(residual)) return false;
  stats.residual = reference > 0.0 ? residual / reference : 0.0;
  if (stats.residual > options_.newton_tolerance) stats.flags |= kNotConverged;
  finish(exact, state);
  return true;
}

// Makes the fast iteration. Returns true if it converged, or if its best point is accepted.
bool StageSolver::iterate(StageProblem& problem, linear::VertexField& x, StepStats& stats) {
  double best = std::numeric_limits<double>::infinity();
  if (stop_.is_met()) return false;
  equation_.evaluate(problem, x, residual_);
  const double scale = solve_first(problem, x, stats);
  int last = std::max(options_.newton_iterations, contact_.touches() ? kContactIterations : 0);
  bool has_more = false;  // last allows for kFrictionIterations
  ++stats.newton_iterations;
  make_step(problem, increment_, false, x);
  for (int i = 1;; ++i) {
    if (stop_.is_met()) return false;
    const double relative = add_contact(problem, scale, x) / scale;
    if (relative <= tolerance(problem, scale)) {
      stats.residual = std::max(stats.residual, relative);
      return true;
    }
    if (relative < best) {
      best = relative;
      best_ = x;
    }
    if (relative <= options_.newton_tolerance && !has_more) {
      has_more = true;
      last = std::max(last, i + kFrictionIterations);
    }
    if (i >= last || !std::isfinite(relative)) break;
    solve_next(problem, x, true, stats);
    ++stats.newton_iterations;
    make_step(problem, step_, contact_.touches(), x);
  }
  if (!(best <= (contact_.touches() ? kNearly : std::numeric_limits<double>::max()))) return false;
  x = best_;
  if (contact_.touches()) {
    contact_.detect(x);
    contact_.project(x);
  }
  return accept(problem, x, best, stats);
}

double StageSolver::tolerance(const StageProblem& problem, double scale) const {
  const double friction = kOfFriction * problem.stage.d * problem.stage.d * contact_.friction_norm();
  if (friction == 0.0) return options_.newton_tolerance;
  return std::min(options_.newton_tolerance, std::max(friction, rounding_) / scale);
}

void StageSolver::make_step(const StageProblem& problem, const linear::VertexField& solution, bool may_shorten,
                            linear::VertexField& x) {
  const double d = problem.stage.d;
  const double before = may_shorten ? dot(residual_, step_) - d * d * contact_.work(step_) : 0.0;
  trial_ = x + step_;
  equation_.evaluate(problem, trial_, residual_);
  const double share =
      may_shorten ? contact_.share_without_overshoot(step_, d * d, before, dot(residual_, step_)) : 1.0;
  if (share < 1.0) {
    step_ *= share;
    trial_ = x + step_;
    equation_.evaluate(problem, trial_, residual_);
  }
  contact_.follow(solution, share);
  predict_stress(problem.model.element_blocks(), problem.model.materials(), x, step_, stress_);
  x = trial_;
}

bool StageSolver::accept(const StageProblem& problem, const linear::VertexField& x, double residual,
                         StepStats& stats) const {
  StageProblem undamped = problem;
  undamped.beta = {};
  const double reached = merit(undamped, x, start_);
  if (!std::isfinite(reached) || !(reached <= merit(undamped, start_, start_))) return false;
  stats.flags |= kNotConverged;
  stats.residual = std::max(stats.residual, residual);
  return true;
}

void StageSolver::solve_next(StageProblem& problem, const linear::VertexField& x, bool predicted, StepStats& stats) {
  linear::LinearSolver& solver = predicted || !repair_solver_ ? *solver_ : *repair_solver_;
  do {
    assemble(problem, x, predicted);
    rhs_ = residual_;
    contact_.add_gap_forces(problem.stage.d * problem.stage.d, rhs_);
    step_.setZero();
    constrain(problem, x);
    contact_.add_stiffness(problem.stage.d * problem.stage.d, matrix_.blocks());
  } while (!solve_linear(solver, problem, stats, step_));
}

// The unknown of the linear system is the departure from ballistic motion that ends at the surfaces it meets.
// Tolerances are thus relative to the effect of forces, not to the momentum of a moving sheet. Free fall is exact.
double StageSolver::solve_first(StageProblem& problem, const linear::VertexField& x, StepStats& stats) {
  const double d = problem.stage.d;
  double whole = 0.0;
  double departure = 0.0;
  do {
    assemble(problem, x, true);
    rhs_ = residual_;
    step_ = problem.stage.ballistic - x;
    for (Eigen::Index i = 0; i < step_.cols(); ++i) {
      // Vertices without material do not move.
      if (problem.model.mass()[static_cast<std::size_t>(i)] == 0.0) step_.col(i).setZero();
    }
    contact_.predict(x, residual_, step_);
    constrain(problem, x);
    whole = rhs_.norm();
    matrix_.blocks().multiply(step_, increment_);
    rhs_ -= increment_;
    contact_.add_forces(d * d, rhs_);
    departure = rhs_.norm();
    contact_.add_stiffness(d * d, matrix_.blocks());
    increment_.setZero();
  } while (!solve_linear(*solver_, problem, stats, increment_));
  step_ += increment_;
  // Rounding of internal and of inertial forces.
  const std::span<const double> mass = problem.model.mass();
  const double stiffness = d * d * problem.model.materials().largest_membrane_trace();
  rounding_ = std::numeric_limits<double>::epsilon() * x.cwiseAbs().maxCoeff() *
              (stiffness * std::sqrt(static_cast<double>(x.cols())) +
               Eigen::Map<const Eigen::VectorXd>(mass.data(), x.cols()).norm());
  constexpr double kMomentumShare = 1e-3;
  return std::max(
      {departure, kMomentumShare * whole, rounding_ / options_.newton_tolerance, std::numeric_limits<double>::min()});
}

bool StageSolver::repair(StageProblem& problem, const linear::VertexField& start, linear::VertexField& x,
                         StepStats& stats) {
  stats.flags |= kRepaired;
  contact_.begin_penalty();
  x = start;
  double reference = 0.0;
  double relative = 0.0;
  for (int i = 0; i < kRepairIterations; ++i) {
    if (stop_.is_met()) return false;
    const double residual = evaluate_residual(problem, x);
    const double value = merit(problem, x, x);
    if (!std::isfinite(value)) return false;
    reference = std::max(reference, residual);
    relative = reference > 0.0 ? residual / reference : 0.0;
    if (relative <= options_.newton_tolerance) break;
    solve_next(problem, x, false, stats);
    ++stats.newton_iterations;
    if (!step_.allFinite() || !search_line(problem, value, x)) break;
  }
  contact_.detect(x);
  stats.residual = std::max(stats.residual, relative);
  if (relative > options_.newton_tolerance) stats.flags |= kNotConverged;
  return true;
}

// Armijo backtracking along step_. Returns false if no step lowers the potential any more.
bool StageSolver::search_line(const StageProblem& problem, double value, linear::VertexField& x) {
  constexpr double kSufficientDecrease = 1e-4;
  const double slope = dot(residual_, step_);
  double scale = 1.0;
  for (int i = 0; i < kMaxBacktracks; ++i, scale *= 0.5) {
    trial_ = x + scale * step_;
    if (!(merit(problem, trial_, x) < value - kSufficientDecrease * scale * slope)) continue;
    x = trial_;
    return true;
  }
  return false;
}

double StageSolver::add_contact(const StageProblem& problem, double scale, const linear::VertexField& x) {
  const double d2 = problem.stage.d * problem.stage.d;
  contact_.detect(x);
  contact_.add_forces(d2, residual_);
  const auto norm = [&] { return std::hypot(residual_.norm(), d2 * contact_.gap_norm()); };
  if (!contact_.touches()) return residual_.norm();
  const double found = norm();
  if (!(found <= std::min(kSettled * scale, kSettledContact * d2 * contact_.normal_norm()))) return found;
  contact_.release(d2, residual_);
  return norm();
}

double StageSolver::evaluate_residual(const StageProblem& problem, const linear::VertexField& x) {
  equation_.evaluate(problem, x, residual_);
  contact_.detect(x);
  contact_.add_forces(problem.stage.d * problem.stage.d, residual_);
  return residual_.norm();
}

double StageSolver::merit(const StageProblem& problem, const linear::VertexField& x,
                          const linear::VertexField& origin) const {
  return incremental_potential(problem, contact_.potential(x), x, origin);
}

bool StageSolver::solve_linear(linear::LinearSolver& solver, StageProblem& problem, StepStats& stats,
                               linear::VertexField& x) {
  double tolerance = options_.linear_tolerance;
  const double friction = problem.stage.d * problem.stage.d * contact_.friction_norm();
  if (friction > 0.0) {
    constexpr double kShare = 0.25;  // -, of the error that Newton's method may have
    tolerance = std::min(tolerance, std::max(kLeastLinearTolerance, kShare * kOfFriction * friction / rhs_.norm()));
  }
  const linear::LinearStats linear = solver.solve(matrix_.blocks(), rhs_, tolerance, x);
  stats.linear_iterations += linear.iterations;
  if (!linear.converged && problem.has_follower_tangent) {
    problem.has_follower_tangent = false;
    return false;
  }
  if (!linear.converged) stats.flags |= kNotConverged;
  const bool is_bounded = linear.residual < kWorstLinearResidual;
  stats.linear_residual = std::max(stats.linear_residual, is_bounded ? linear.residual : kWorstLinearResidual);
  return true;
}

}  // namespace kerf::fem
