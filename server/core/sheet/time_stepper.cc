#include "server/core/sheet/time_stepper.h"

#include <algorithm>
#include <new>
#include <utility>

#include "server/base/interruption.h"
#include "server/core/fem/model/condition.h"
#include "server/core/scene/integrator_settings.h"

namespace kerf::sheet {

TimeStepper::TimeStepper(const scene::SheetConfig& config, IntegratorFactory make_integrator, double size)
    : dt_(1.0 / config.tick_rate_hz),
      integrator_(std::move(make_integrator), scene::integrator_options(config, config.self_contact.is_on)),
      rest_(size) {
  contact_.set_colliders(config.colliders);
  contact_.set_self_contact(config.self_contact);
}

void TimeStepper::set_self_contact(const scene::SelfContact& settings) {
  contact_.set_self_contact(settings);
  integrator_.set_touches_itself(settings.is_on);
  forget_counts();
}

void TimeStepper::rebuild(const fem::Model& model, const std::optional<fem::Softening>& softening,
                          Eigen::Index num_vertices) {
  integrator_->rebuild(model);
  make_room(model, softening, num_vertices);
}

void TimeStepper::follow(const fem::Model& model, const std::optional<fem::Softening>& softening,
                         Eigen::Index num_vertices, bool rebuilds) {
  if (rebuilds || is_frozen_) {  // the last step may have left the integrator in an intermediate state
    integrator_->rebuild(model);
  } else {
    integrator_->follow(model);
  }
  make_room(model, softening, num_vertices);
}

void TimeStepper::make_room(const fem::Model& model, const std::optional<fem::Softening>& softening,
                            Eigen::Index num_vertices) {
  description_ =
      std::string(integrator_->explanation()) + "; " + fem::describe_condition(fem::condition_number(model, dt_));
  if (softening) description_ += "; " + fem::describe(*softening);
  last_good_.x.resize(num_vertices);
  last_good_.v.resize(num_vertices);
  rest_.make_room(num_vertices);
}

StepOutcome TimeStepper::step(fem::Model& model, const fem::Loads& loads, const StopConditions& stop,
                              fem::State& state) {
  StepOutcome outcome;
  fem::StepStats& stats = outcome.stats;
  last_good_ = state;
  model.bend_by_matrix();
  integrator_->set_stop_condition(stop.end_early);
  const bool touches = last_counts_ && last_counts_->contact_blocks > 0.0;
  contact_.set_calm(touches && rest_.is_calm());
  const std::int64_t blocks_before = contact_.blocks();
  contact_.begin_self_stats();
  outcome.gave_up = !integrate(model, loads, stop.give_up, state, stats);
  integrator_->set_stop_condition(nullptr);
  if (outcome.gave_up) {
    state = last_good_;
    is_frozen_ = true;
    stats = {};
    stats.interrupted = true;
  }
  if (stats.interrupted) return outcome;
  if (!state.x.allFinite() || !state.v.allFinite()) stats.flags |= fem::kFrozen;
  outcome.failed = (stats.flags & fem::kFrozen) != 0;
  if (outcome.failed) {
    stats.simulated = 0.0;
    state = last_good_;
    if (++failed_steps_ >= Sheet::kMaxFailedSteps) is_frozen_ = true;
  } else {
    failed_steps_ = 0;
    stats.self_contact = contact_.take_self_stats(state.x);
    if (stats.self_contact.intersections > 0) stats.flags |= fem::kIntersects;
    count_tick(model, stats, contact_.blocks() - blocks_before);
  }
  return outcome;
}

bool TimeStepper::integrate(const fem::Model& model, const fem::Loads& loads, const StopCondition* give_up,
                            fem::State& state, fem::StepStats& stats) {
  try {
    std::optional<InterruptionScope> scope;
    if (give_up != nullptr) scope.emplace(*give_up);
    stats = integrator_->step(model, loads, dt_, contact_.empty() ? nullptr : &contact_, state);
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  } catch (const Interrupted&) {
    return false;
  }
}

void TimeStepper::count_tick(const fem::Model& model, const fem::StepStats& stats, std::int64_t contact_blocks) {
  const double substeps = std::max(stats.substeps, 1);
  const fem::TickCost planned = integrator_->expected_cost(model, dt_, {});
  last_counts_ = fem::TickCounts{
      .contact_blocks = static_cast<double>(contact_blocks) / substeps,
      .cluster_pushes = stats.cluster_pushes / substeps,
      .load_phases = stats.load_phases / substeps,
      .more_substeps = planned.substeps > 0.0 ? substeps / planned.substeps : 1.0,
      .more_kicks = stats.bending_interval > 0 ? planned.bending_interval / stats.bending_interval : 1.0,
      .is_double = stats.is_double,
      .newton_iterations = static_cast<double>(stats.newton_iterations),
      .linear_iterations = static_cast<double>(stats.linear_iterations),
      .self_contact = {.phases = static_cast<double>(stats.self_contact.phases),
                       .searches = static_cast<double>(stats.self_contact.searches),
                       .pairs = static_cast<double>(stats.self_contact.pairs),
                       .contacts = static_cast<double>(stats.self_contact.contacts),
                       .repairs = static_cast<double>(stats.self_contact.repairs)}};
}

void TimeStepper::watch_rest(const fem::Model& model, const RestWatch::Tick& tick, fem::State& state) {
  rest_.after_tick(model, tick, state);
}

void TimeStepper::restore(std::int32_t failed_steps, bool is_frozen) {
  failed_steps_ = failed_steps;
  is_frozen_ = is_frozen;
  forget_counts();
}

void TimeStepper::resume() {
  contact_.set_self_contact(contact_.self_contact());
  integrator_.set_touches_itself(contact_.touches_itself());
}

fem::TickCost TimeStepper::expected_cost(const fem::Model& model, const fem::TickCounts& first) const {
  fem::TickCounts counts = last_counts_ ? *last_counts_ : first;
  if (!last_counts_ && contact_.touches_itself()) {
    const double substeps = integrator_->expected_cost(model, dt_, {}).substeps;
    counts.self_contact = fem::expected_self_contact(substeps, static_cast<double>(model.num_vertices()));
  }
  // If the sheet is no longer calm, the next tick is not like the last one.
  if (last_counts_ && contact_.is_calm() && !rest_.is_calm()) counts.more_substeps = counts.more_kicks = 1.0;
  return integrator_->expected_cost(model, dt_, counts);
}

}  // namespace kerf::sheet
