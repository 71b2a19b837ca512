#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "server/base/stop_condition.h"
#include "server/core/fem/step/integrator_options.h"
#include "server/core/fem/step/step_stats.h"

namespace kerf::fem {

class ContactConstraint;
class Model;
struct Grab;
struct Loads;
struct Pin;
struct State;
struct TickCost;
struct TickCounts;

// Advances the state of a sheet. Each sheet has its own integrator; it is not thread-safe.
class Integrator {
 public:
  virtual ~Integrator() = default;

  // Must be called before the first step, and after every Model::apply or follow unless follow() is called instead.
  // Allocates the memory of step().
  virtual void rebuild(const Model& model) = 0;
  // Updates after exactly one Model::follow since the previous call of rebuild() or follow(). Unchanged parts need not
  // be visited.
  virtual void follow(const Model& model) { rebuild(model); }
  // Must be called once between any number of follow() calls and the next step. Does work that follow() deferred
  // because further cuts would undo it. Allocates the memory of step().
  virtual void prepare() {}
  // Sets the stop condition of later steps, polled once a substep, an iteration and a supernode of a factorisation. A
  // stopped step ends early with StepStats::interrupted. Null, the default, means none.
  void set_stop_condition(const StopCondition* stop) { stop_.set(stop); }

  // Advances `state` by dt (s, > 0). Never allocates, throws or logs; on failure (kFrozen) `state` is unchanged. The
  // result depends on the arguments alone, not on earlier steps. `contact` may be null.
  virtual StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact,
                         State& state) = 0;

  // Must be called before mobility() with the pins of the coming step. Does not allocate.
  virtual void hold(std::span<const Pin> /*pins*/) {}
  // 1/kg, largest component of the change of velocity of the grab's point per impulse on it. It is the sum of weight^2
  // / m over the grab's vertices, unless they are in clusters.
  [[nodiscard]] virtual double mobility(const Model& model, const Grab& grab) const;

  // Explains for people which integrator runs and why; valid until the next rebuild.
  [[nodiscard]] virtual std::string_view explanation() const = 0;
  // Integrator that runs; never kAutomatic.
  [[nodiscard]] virtual IntegratorKind kind() const = 0;
  // Clusters, and the substeps of a step of dt, s, with and without them. Empty if there are none, as for implicit
  // integrators.
  [[nodiscard]] virtual std::optional<LocalInertiaStats> local_inertia(double /*dt*/) const { return std::nullopt; }
  // Estimates the cost of a tick of one step of dt, s. `model` is that of the last rebuild() or follow(), and `last`
  // has the counts of the tick before. 0 if unknown.
  [[nodiscard]] virtual TickCost expected_cost(const Model& model, double dt, const TickCounts& last) const;

 protected:
  StopPoll stop_;
};

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options);

}  // namespace kerf::fem
