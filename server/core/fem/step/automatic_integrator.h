#pragma once

#include <memory>
#include <optional>
#include <string>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tick_cost.h"
#include "server/core/fem/step/explicit_integrator.h"
#include "server/core/fem/step/integrator.h"

namespace kerf::fem {

// -, computing time that a tick of steps may take, over its duration. The remainder is left to contact, cuts and ticks
// of a sheet at rest.
inline constexpr double kShareOfTick = 0.8;

// Estimated cost of a tick of IntegratorOptions::tick seconds, from counts alone. It leaves out contact and loads on
// vertices, which cost time in implicit steps as well.
struct TickEstimate {
  double substeps = 0.0;     // substeps of an explicit tick
  double explicit_ns = 0.0;  // ns on one core of 2024, with explicit steps
  double implicit_ns = 0.0;  // ns, with TR-BDF2, or with SDIRK2 where that would be taken
  bool is_explicit = true;   // true if the tick is explicit: by options.kind, or by the choice of kAutomatic
};
// Estimates a tick of the model. Makes no step.
TickEstimate estimate_tick(const Model& model, const IntegratorOptions& options);

// Chooses an integrator at each rebuild, from the model and IntegratorOptions::tick alone. Costs are estimated in
// nanoseconds without a clock, so the choice is the same on every machine.
//  - Explicit steps if they are estimated to fit kShareOfTick of the tick.
//  - Explicit steps that do not fit, unless TR-BDF2 is estimated at less than a sixth of their cost. At equal cost
//    explicit steps are by far the more accurate. With clusters of local inertia it need only be cheaper.
//  - Up to twenty times the cost of TR-BDF2 if the sheet has contact with itself: implicit steps only correct its ends.
//  - Otherwise TR-BDF2: no other implicit scheme has a smaller error for its time (tests/accuracy/PLOTS.md).
//  - SDIRK2 in place of TR-BDF2 above a condition number of 1e9, as slivers of crossing cuts have. The forces at the
//    start of a step, which the trapezoidal rule uses, are mostly rounding there.
// Implicit steps make up to five Newton iterations a solve, or more if asked. The estimates count those
// that are asked, and all with clusters where the sheet does not touch itself.
// TR-BDF2 uses kFactorCg from kLeastForFactorCg vertices on, where it takes 0.3 to 0.9 of the direct solver's time.
// Smaller sheets use the direct solver; only slivers make them stiff enough for TR-BDF2. SDIRK2 uses the direct solver
// as well, because floats are too inaccurate for its matrices.
//
// That is AutomaticChoice::kSecond. In kFirst the first rule is missing, implicit Euler stands in place of SDIRK2, and
// solves make as many Newton iterations as are asked. Its limits are a quarter, and two thirds with clusters.
class AutomaticIntegrator final : public Integrator {
 public:
  explicit AutomaticIntegrator(const IntegratorOptions& options);

  void rebuild(const Model& model) override;
  void follow(const Model& model) override;
  void prepare() override { chosen().prepare(); }
  StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact, State& state) override;
  void hold(std::span<const Pin> pins) override { chosen().hold(pins); }
  [[nodiscard]] double mobility(const Model& model, const Grab& grab) const override {
    return implicit_ ? implicit_->mobility(model, grab) : explicit_.mobility(model, grab);
  }
  [[nodiscard]] std::string_view explanation() const override { return explanation_; }
  [[nodiscard]] IntegratorKind kind() const override;
  [[nodiscard]] std::optional<LocalInertiaStats> local_inertia(double dt) const override {
    return implicit_ ? implicit_->local_inertia(dt) : explicit_.local_inertia(dt);
  }
  [[nodiscard]] TickCost expected_cost(const Model& model, double dt, const TickCounts& last) const override;

 private:
  // Sets implicit_ to the choice for the model. `follows` is that of ExplicitIntegrator::plan(). Returns true if the
  // choice changed: the integrator must then be rebuilt.
  bool choose(const Model& model, bool follows);
  Integrator& chosen() { return implicit_ ? *implicit_ : explicit_; }

  IntegratorOptions options_;
  ExplicitIntegrator explicit_;
  std::unique_ptr<Integrator> implicit_;                                 // null while the explicit integrator is chosen
  linear::LinearSolverKind solver_ = linear::LinearSolverKind::kDirect;  // of implicit_
  std::string explanation_;
};

}  // namespace kerf::fem
