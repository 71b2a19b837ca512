#pragma once

#include <cstdint>
#include <optional>
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

namespace kerf::sheet {

// Conditions under which a step ends early; either may be null. See Sheet::step().
struct StopConditions {
  const StopCondition* end_early = nullptr;  // ends the integration early
  const StopCondition* give_up = nullptr;    // gives the step up, at any point
};

// Result of one step; see the fields of the same names in TickReport.
struct StepOutcome {
  fem::StepStats stats;
  bool gave_up = false;
  bool failed = false;
};

// Advances the state of a sheet: the integrator with contact, the treatment of failed steps, and the watch for rest.
// The mesh, the model and the state are the owner's, who calls rebuild() or follow() after every change of them.
class TimeStepper {
 public:
  // `size`: m, the larger side of the sheet as built.
  TimeStepper(const SheetConfig& config, IntegratorFactory make_integrator, double size);

  // Follows a new model. Allocates all that a step needs.
  void rebuild(const fem::Model& model, const std::optional<fem::Softening>& softening, Eigen::Index num_vertices);
  // Follows a model after exactly one Model::follow. `rebuilds`: the integrator must be rebuilt anyway.
  void follow(const fem::Model& model, const std::optional<fem::Softening>& softening, Eigen::Index num_vertices,
              bool rebuilds);
  // Rebuilds the integrator alone: the model holds the slopes of other vertices, or this is a copy.
  void rebuild_integrator(const fem::Model& model) { integrator_->rebuild(model); }
  // Must be called between any number of follow() and the next step.
  void prepare() { integrator_->prepare(); }

  // Advances `state` by a tick. Where the step fails or gives up, `state` is as it was. Never allocates.
  StepOutcome step(fem::Model& model, const fem::Loads& loads, const StopConditions& stop, fem::State& state);
  // Brings a sheet to rest that nothing acts on any more; see RestWatch::after_tick().
  void watch_rest(const fem::Model& model, const RestWatch::Tick& tick, fem::State& state);
  // Notes that something other than the sheet's own motion changed it, or may change it.
  void disturb() { rest_.disturb(); }

  [[nodiscard]] const fem::Integrator& integrator() const { return *integrator_; }
  [[nodiscard]] const std::string& description() const { return description_; }  // which integrator runs and why
  [[nodiscard]] ContactBridge& contact() { return contact_; }
  [[nodiscard]] const ContactBridge& contact() const { return contact_; }
  [[nodiscard]] bool is_at_rest() const { return rest_.is_at_rest(); }

  // Steps that failed in a row. After Sheet::kMaxFailedSteps of them, or one that gave up, the sheet is frozen.
  [[nodiscard]] std::int32_t failed_steps() const { return failed_steps_; }
  [[nodiscard]] bool is_frozen() const { return is_frozen_; }
  void restore(std::int32_t failed_steps, bool is_frozen);

  // Estimates the cost of a tick after one like the last. `first`: counts expected of a first one.
  [[nodiscard]] fem::TickCost expected_cost(const fem::Model& model, const fem::TickCounts& first) const;
  // Forgets the counts of the last tick, which the next will not be like.
  void forget_counts() { last_counts_.reset(); }

 private:
  // Allocates all that a step needs, once the integrator follows the model.
  void make_room(const fem::Model& model, const std::optional<fem::Softening>& softening, Eigen::Index num_vertices);
  // Returns false if the integrator ran out of memory or was interrupted; `state` is invalid then.
  bool integrate(const fem::Model& model, const fem::Loads& loads, const StopCondition* give_up, fem::State& state,
                 fem::StepStats& stats);
  // Keeps the counts of a step that did not fail. contact_blocks: in all its substeps.
  void count_tick(const fem::Model& model, const fem::StepStats& stats, std::int64_t contact_blocks);

  double dt_;  // s
  OwnedIntegrator integrator_;
  std::string description_;
  ContactBridge contact_;
  RestWatch rest_;
  std::optional<fem::TickCounts> last_counts_;  // since the scene began
  std::int32_t failed_steps_ = 0;
  bool is_frozen_ = false;
  fem::State last_good_;  // scratch of a step
};

}  // namespace kerf::sheet
