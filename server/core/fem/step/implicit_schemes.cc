#include "server/core/fem/step/implicit_integrator.h"

#include <span>

#include "server/core/fem/element/follower_loads.h"
#include "server/core/fem/element/grab_point.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/element/wind_drag.h"
#include "server/core/fem/model/model.h"

// Members of ImplicitIntegrator that make a substep: one for each scheme, and what schemes share.
namespace kerf::fem {

bool ImplicitIntegrator::advance(const Model& model, const Loads& loads, const Substep& substep, State& state,
                                 StepStats& stats) {
  evaluate_constant_force(model, loads, substep.h, state, stats);
  switch (substep.kind) {
    case IntegratorKind::kTrBdf2:
      return advance_tr_bdf2(model, loads, substep, state, stats);
    case IntegratorKind::kTrapezoidal:
      return advance_trapezoidal(model, loads, substep, state, stats);
    case IntegratorKind::kSdirk2:
      return advance_sdirk2(model, loads, substep, state, stats);
    case IntegratorKind::kBdf2:
      return advance_bdf2(model, loads, substep, state, stats);
    default:
      return advance_euler(model, loads, substep, state, stats);
  }
}

// Sets scratch_.stage.ballistic for a stage that lasts t (s) from `start`. t2 (s^2) is the factor of gravity in the
// displacement.
void ImplicitIntegrator::set_ballistic(const State& start, double t, double t2, const Eigen::Vector3d& gravity) {
  scratch_.stage.ballistic = (start.x + t * start.v).colwise() + t2 * gravity;
}

// Sets the stage of the trapezoidal rule that begins at `start`; scratch_.stage.d is half of its length.
void ImplicitIntegrator::begin_trapezoidal(const Model& model, const Loads& loads, double time_left,
                                           const State& start) {
  Stage& stage = scratch_.stage;
  evaluate_acceleration(model, loads, time_left, start);
  stage.base.x = start.x + stage.d * start.v;
  stage.base.v = start.v + stage.d * scratch_.force;
  stage.momentum = model.momentum(start).linear;
  stage.momentum += stage.d * follower_resultant(model.element_blocks(), loads, start.x);
  for (Eigen::Index i = 0; i < start.v.cols(); ++i) {
    const Eigen::Vector3d a = loads.gravity - model.masses().damping(static_cast<int>(i)) * start.v.col(i);
    stage.momentum += stage.d * (model.mass()[static_cast<std::size_t>(i)] * a + scratch_.constant.col(i));
  }
  set_ballistic(start, 2.0 * stage.d, 2.0 * stage.d * stage.d, loads.gravity);
}

// Sets the stage of implicit Euler that lasts scratch_.stage.d from `start`.
void ImplicitIntegrator::begin_euler(const Model& model, const Loads& loads, const State& start) {
  Stage& stage = scratch_.stage;
  stage.base.x = start.x;
  stage.base.v = start.v;
  stage.momentum = model.momentum(stage.base).linear;
  stage.continues = false;
  set_ballistic(start, stage.d, stage.d * stage.d, loads.gravity);
}

bool ImplicitIntegrator::advance_euler(const Model& model, const Loads& loads, const Substep& substep, State& state,
                                       StepStats& stats) {
  Stage& stage = scratch_.stage;
  stage.d = substep.h;
  begin_euler(model, loads, state);
  stage.start = &stage.base.x;
  stage.time_left = substep.time_left;
  if (substep.is_majorized) return solver_.solve_majorized(model, loads, scratch_.constant, stage, state, stats);
  return solver_.solve(model, loads, scratch_.constant, stage, state, stats);
}

bool ImplicitIntegrator::advance_tr_bdf2(const Model& model, const Loads& loads, const Substep& substep, State& state,
                                         StepStats& stats) {
  const double h = substep.h;
  constexpr double kGamma = 0.58578643762690495;  // 2 - sqrt 2
  constexpr double kNew = 1.0 / (kGamma * (2.0 - kGamma));
  Stage& stage = scratch_.stage;
  State& start = scratch_.substep_start;
  start.x = state.x;
  start.v = state.v;
  stage.start = &start.x;
  stage.d = 0.5 * kGamma * h;
  stage.continues = false;

  begin_trapezoidal(model, loads, substep.time_left + h, state);
  stage.time_left = substep.time_left + (1.0 - kGamma) * h;
  if (!solver_.solve(model, loads, scratch_.constant, stage, state, stats)) return false;
  constexpr double kOld = (1.0 - kGamma) * (1.0 - kGamma) / (kGamma * (2.0 - kGamma));
  return advance_last(model, loads, substep, kNew, kOld, state, stats);
}

bool ImplicitIntegrator::advance_sdirk2(const Model& model, const Loads& loads, const Substep& substep, State& state,
                                        StepStats& stats) {
  constexpr double kGamma = 0.29289321881345248;  // 1 - 1 / sqrt 2
  constexpr double kNew = (1.0 - kGamma) / kGamma;
  Stage& stage = scratch_.stage;
  State& start = scratch_.substep_start;
  start.x = state.x;
  start.v = state.v;
  stage.start = &start.x;
  stage.d = kGamma * substep.h;
  begin_euler(model, loads, state);
  stage.time_left = substep.time_left + (1.0 - kGamma) * substep.h;
  if (!solver_.solve(model, loads, scratch_.constant, stage, state, stats)) return false;
  return advance_last(model, loads, substep, kNew, kNew - 1.0, state, stats);
}

// Advances from the first of two stages to the end of the substep. The second stage begins at `now` times the end of
// the first less `old` times the start of the substep, where now - old is 1.
bool ImplicitIntegrator::advance_last(const Model& model, const Loads& loads, const Substep& substep, double now,
                                      double old, State& state, StepStats& stats) {
  Stage& stage = scratch_.stage;
  scratch_.before.x = scratch_.substep_start.x;
  scratch_.before.v = scratch_.substep_start.v;
  forget_stopped(state.x);
  stage.base.x = now * state.x - old * scratch_.before.x;
  stage.base.v = now * state.v - old * scratch_.before.v;
  stage.momentum = model.momentum(stage.base).linear;
  set_ballistic(stage.base, stage.d, stage.d * stage.d, loads.gravity);
  stage.continues = true;
  stage.time_left = substep.time_left;
  return solver_.solve(model, loads, scratch_.constant, stage, state, stats);
}

bool ImplicitIntegrator::advance_trapezoidal(const Model& model, const Loads& loads, const Substep& substep,
                                             State& state, StepStats& stats) {
  const double h = substep.h;
  Stage& stage = scratch_.stage;
  State& start = scratch_.substep_start;
  start.x = state.x;
  start.v = state.v;
  stage.start = &start.x;
  stage.d = 0.5 * h;
  stage.continues = false;
  begin_trapezoidal(model, loads, substep.time_left + h, state);
  stage.time_left = substep.time_left;
  return solver_.solve(model, loads, scratch_.constant, stage, state, stats);
}

bool ImplicitIntegrator::advance_bdf2(const Model& model, const Loads& loads, const Substep& substep, State& state,
                                      StepStats& stats) {
  const double h = substep.h;
  Stage& stage = scratch_.stage;
  State& start = scratch_.substep_start;
  State& before = scratch_.before;
  if (substep.index == 0) {
    if (!advance_trapezoidal(model, loads, substep, state, stats)) return false;
  } else {
    start.x = state.x;
    start.v = state.v;
    stage.start = &start.x;
    stage.d = 2.0 * h / 3.0;
    stage.continues = true;
    forget_stopped(start.x);
    stage.base.x = (4.0 * start.x - before.x) / 3.0;
    stage.base.v = (4.0 * start.v - before.v) / 3.0;
    stage.momentum = model.momentum(stage.base).linear;
    set_ballistic(stage.base, stage.d, stage.d * stage.d, loads.gravity);
    stage.time_left = substep.time_left;
    evaluate_constant_force(model, loads, stage.d, stage.base, stats);  // drag is limited by the masses it acts on
    if (!solver_.solve(model, loads, scratch_.constant, stage, state, stats)) return false;
  }
  before.x = start.x;
  before.v = start.v;
  return true;
}

// Changes scratch_.before, from which a stage extrapolates to beyond positions x (m). What surfaces stopped in the
// stage before counts as never having moved; it would be thrown back otherwise.
void ImplicitIntegrator::forget_stopped(const linear::VertexField& x) {
  if (scratch_.stage.contact == nullptr) return;
  State& before = scratch_.before;
  solver_.stop_in_contact(before.v);
  before.x = x - before.x;
  solver_.stop_in_contact(before.x);
  before.x = x - before.x;
}

void ImplicitIntegrator::evaluate_constant_force(const Model& model, const Loads& loads, double h, const State& state,
                                                 StepStats& stats) {
  if (loads.external_forces.cols() > 0) {
    scratch_.constant = loads.external_forces;
  } else {
    scratch_.constant.setZero();
  }
  if (!has_wind_drag(loads.wind)) return;
  add_wind_drag(model.element_blocks(), model.materials(), loads.wind, h, state, scratch_.constant);
  ++stats.load_phases;
}

void ImplicitIntegrator::evaluate_acceleration(const Model& model, const Loads& loads, double time_left,
                                               const State& state) {
  const std::span<const double> beta = model.materials().stiffness_damping();
  linear::VertexField& f = scratch_.force;
  f = scratch_.constant;
  add_membrane_forces(model.element_blocks(), model.materials(), beta, state.x, state.v, f);
  model.bending().add_forces(model.element_blocks(), state.x, state.v, beta, scratch_.damped, f);
  add_follower_forces(model.element_blocks(), loads, state.x, f);
  for (const Grab& grab : loads.grabs) {
    const Eigen::Vector3d target = grab.target - time_left * grab.velocity;
    const Eigen::Vector3d pull = grab.stiffness * (target - grab_point(grab, state.x)) +
                                 grab.damping * (grab.velocity - grab_point(grab, state.v));
    for (std::size_t k = 0; k < 3; ++k) {
      if (grab.vertices[k] == mesh::kNone) continue;
      f.col(grab.vertices[k]) += grab.weights[static_cast<Eigen::Index>(k)] * pull;
    }
  }
  for (Eigen::Index i = 0; i < f.cols(); ++i) {
    const double w = model.inverse_mass()[static_cast<std::size_t>(i)];
    const Eigen::Vector3d a =
        w * f.col(i) + loads.gravity - model.masses().damping(static_cast<int>(i)) * state.v.col(i);
    f.col(i).setZero();
    if (w > 0.0) f.col(i) = a;
  }
}

}  // namespace kerf::fem
