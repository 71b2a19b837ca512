#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/base/stop_condition.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tick_cost.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/fem/step/softening.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/contact_bridge.h"
#include "server/core/sheet/owned_integrator.h"
#include "server/core/sheet/rest_watch.h"
#include "server/core/sheet/sheet.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

// Conditions that end a step early; each may be null. See Sheet::step().
struct StopConditions {
  const StopCondition* end_early = nullptr;  // Sheet::step(): `stop`
  const StopCondition* give_up = nullptr;    // Sheet::step(): `give_up`
};

// Result of one step. The members mean stats, gave_up and step_failed of TickReport.
struct StepOutcome {
  fem::StepStats stats;
  bool gave_up = false;
  bool failed = false;
};

// Advances the state of a sheet: runs the integrator with contact, handles failed steps and watches for rest. Mesh,
// model and state belong to the owner, who calls rebuild() or follow() after every change of them.
class TimeStepper {
 public:
  // `size`: larger side of the sheet as built, m.
  TimeStepper(const scene::SheetConfig& config, IntegratorFactory make_integrator, double size);

  // Replaces the settings of contact of the sheet with itself. If it was turned on or off, rebuild() must be called
  // next, after ContactBridge::set_mesh().
  void set_self_contact(const scene::SelfContact& settings);
  // Must be called after the model was replaced. Allocates all memory that a step needs.
  void rebuild(const fem::Model& model, const std::optional<fem::Softening>& softening, Eigen::Index num_vertices);
  // Must be called after each Model::follow(). `rebuilds`: true if the integrator must be rebuilt for another reason.
  void follow(const fem::Model& model, const std::optional<fem::Softening>& softening, Eigen::Index num_vertices,
              bool rebuilds);
  // Rebuilds only the integrator: after the model has got other clamped vertices, or after a copy.
  void rebuild_integrator(const fem::Model& model) { integrator_->rebuild(model); }
  // Must be called after follow(), before the next step; once is enough for several calls of follow().
  void prepare() { integrator_->prepare(); }

  // Must be called before the mobility of integrator() is asked for, with the pins of the coming step.
  void hold(std::span<const fem::Pin> pins) { integrator_->hold(pins); }

  // Advances `state` by one tick. If the step fails or gives up, `state` does not change. Allocates no memory
  // unless the sheet touches itself.
  StepOutcome step(fem::Model& model, const fem::Loads& loads, const StopConditions& stop, fem::State& state);
  // Calls RestWatch::after_tick(): damps a calm sheet and detects rest.
  void watch_rest(const fem::Model& model, const RestWatch::Tick& tick, fem::State& state);
  // Calls RestWatch::disturb(): something other than its own motion has changed the sheet, or may change it.
  void disturb() { rest_.disturb(); }

  [[nodiscard]] const fem::Integrator& integrator() const { return *integrator_; }
  [[nodiscard]] const std::string& description() const { return description_; }  // which integrator runs, and why
  [[nodiscard]] ContactBridge& contact() { return contact_; }
  [[nodiscard]] const ContactBridge& contact() const { return contact_; }
  [[nodiscard]] bool is_at_rest() const { return rest_.is_at_rest(); }

  // Returns the number of steps that failed in a row. After Sheet::kMaxFailedSteps of them, or one that gave up, the
  // sheet is frozen.
  [[nodiscard]] std::int32_t failed_steps() const { return failed_steps_; }
  [[nodiscard]] bool is_frozen() const { return is_frozen_; }
  void restore(std::int32_t failed_steps, bool is_frozen);
  // Derives everything else after all members that Fields lists were set; rebuild() must be called next.
  void resume();

  // Returns the expected cost of the next tick, if it is like the last one. `first`: counts to assume before the first
  // tick.
  [[nodiscard]] fem::TickCost expected_cost(const fem::Model& model, const fem::TickCounts& first) const;
  // Forgets the counts of the last tick, since the next tick will differ.
  void forget_counts() { last_counts_.reset(); }

 private:
  friend struct Fields<TimeStepper>;
  // Allocates all memory that a step needs. The integrator must follow the model already.
  void make_room(const fem::Model& model, const std::optional<fem::Softening>& softening, Eigen::Index num_vertices);
  // Returns false if the integrator ran out of memory or was interrupted; `state` is invalid then.
  bool integrate(const fem::Model& model, const fem::Loads& loads, const StopCondition* give_up, fem::State& state,
                 fem::StepStats& stats);
  // Stores the counts of a step that did not fail. `contact_blocks`: blocks checked, summed over all substeps.
  void count_tick(const fem::Model& model, const fem::StepStats& stats, std::int64_t contact_blocks);

  double dt_;  // s
  OwnedIntegrator integrator_;
  std::string description_;
  ContactBridge contact_;
  RestWatch rest_;
  std::optional<fem::TickCounts> last_counts_;  // counts of the last tick; empty before the first tick, or after
                                                // forget_counts()
  std::int32_t failed_steps_ = 0;
  bool is_frozen_ = false;
  fem::State last_good_;  // state before the step, to which a failed step returns
};

}  // namespace kerf::sheet
