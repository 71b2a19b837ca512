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

// Cost of a tick of IntegratorOptions::tick seconds, from counts alone. It leaves out contact and loads on vertices,
// which cost implicit steps as well.
struct TickEstimate {
  double substeps = 0.0;     // explicit
  double explicit_ns = 0.0;  // ns on one core of 2024
  double implicit_ns = 0.0;  // ns, for TR-BDF2
  bool is_explicit = true;   // as options.kind says, or as kAutomatic chooses
};
// Plans explicit steps of the model as it is, without making any.
TickEstimate estimate_tick(const Model& model, const IntegratorOptions& options);

// Chooses an integrator at each rebuild, from the model and IntegratorOptions::tick alone. Costs are estimated in
// nanoseconds without a clock, so the choice is the same on every machine.
//  - Explicit, unless TR-BDF2 is estimated at less than a quarter of its cost: at equal cost explicit is by far the
//    more accurate. With clusters of local inertia the limit is two thirds.
//  - TR-BDF2: of the implicit schemes on the front of error against time (tests/accuracy/PLOTS.md).
//  - Implicit Euler above a condition number of kSecondOrderCondition. There the forces at the start of a step, which
//    the trapezoidal rule uses, are mostly rounding.
// TR-BDF2 uses the float factor from kLeastForFactorCg vertices on, where it takes 0.3 to 0.9 of the direct solver's
// time. Smaller sheets, which only slivers make that stiff, use the direct solver. So does implicit Euler, because
// floats lose such matrices.
class AutomaticIntegrator final : public Integrator {
 public:
  explicit AutomaticIntegrator(const IntegratorOptions& options);

  void rebuild(const Model& model) override;
  void follow(const Model& model) override;
  void prepare() override { chosen().prepare(); }
  StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact, State& state) override;
  [[nodiscard]] double mobility(const Model& model, const Grab& grab) const override {
    return implicit_ ? implicit_->mobility(model, grab) : explicit_.mobility(model, grab);
  }
  [[nodiscard]] std::string_view explanation() const override { return explanation_; }
  [[nodiscard]] IntegratorKind kind() const override;
  [[nodiscard]] std::optional<LocalInertiaStats> local_inertia(double dt) const override {
    return implicit_ ? implicit_->local_inertia(dt) : explicit_.local_inertia(dt);
  }
  [[nodiscard]] TickCost expected_cost(const Model& model, double dt, const TickCounts& last) const override {
    return implicit_ ? implicit_->expected_cost(model, dt, last) : explicit_.expected_cost(model, dt, last);
  }

 private:
  // Returns true if the chosen integrator is a new one, which has not been rebuilt for the model yet.
  bool choose(const Model& model, bool follows);
  Integrator& chosen() { return implicit_ ? *implicit_ : explicit_; }

  IntegratorOptions options_;
  ExplicitIntegrator explicit_;
  std::unique_ptr<Integrator> implicit_;                                 // null while the explicit integrator is chosen
  linear::LinearSolverKind solver_ = linear::LinearSolverKind::kDirect;  // of implicit_
  std::string explanation_;
};

}  // namespace kerf::fem
