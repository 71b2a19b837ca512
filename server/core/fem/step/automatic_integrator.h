#pragma once

#include <memory>
#include <optional>
#include <string>

#include "server/core/fem/step/explicit_integrator.h"
#include "server/core/fem/step/integrator.h"

namespace kerf::fem {

// Cost of a tick of IntegratorOptions::tick seconds, from counts alone, without contact and loads on vertices, for
// which implicit steps pay as well.
struct TickEstimate {
  double substeps = 0.0;     // explicit
  double explicit_ns = 0.0;  // ns on one core of 2024
  double implicit_ns = 0.0;  // the same, of TR-BDF2
  bool is_explicit = true;   // as options.kind says, or as kAutomatic chooses
};
// Plans explicit steps of the model as it is, and makes none.
TickEstimate estimate_tick(const Model& model, const IntegratorOptions& options);

// Chooses at each rebuild, from the model and IntegratorOptions::tick alone: estimates in nanoseconds, no clock, so the
// choice is the same on every machine.
//  - Explicit, unless TR-BDF2 is estimated at less than a quarter of its cost: at equal cost it is by far the more
//    accurate. With clusters of local inertia, unless TR-BDF2 is estimated at less than two thirds of it.
//  - TR-BDF2: of the implicit schemes on the front of error against time (tests/accuracy/PLOTS.md).
//  - Implicit Euler above a condition number of kSecondOrderCondition, where the forces at the start of a step, which
//    the trapezoidal rule follows, are mostly rounding.
// With TR-BDF2 the float factor from kLeastForFactorCg vertices on, where it takes 0.3 to 0.9 of the direct solver's
// time; the direct solver on smaller sheets, which only slivers make that stiff, and with implicit Euler, as floats
// lose such matrices.
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
  // Whether the integrator chosen is another one, which knows nothing of the model yet.
  bool choose(const Model& model, bool follows);
  Integrator& chosen() { return implicit_ ? *implicit_ : explicit_; }

  IntegratorOptions options_;
  ExplicitIntegrator explicit_;
  std::unique_ptr<Integrator> implicit_;                 // null while the explicit integrator is the choice
  LinearSolverKind solver_ = LinearSolverKind::kDirect;  // of implicit_
  std::string explanation_;
};

}  // namespace kerf::fem
