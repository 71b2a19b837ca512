#pragma once

#include <string>

#include "server/fem/explicit_integrator.h"
#include "server/fem/implicit_integrator.h"

namespace kerf::fem {

// Chooses at each rebuild between the explicit integrator and implicit Euler, from the model and
// IntegratorOptions::tick alone: an estimate in nanoseconds, no clock, so the choice is the same on every machine.
// Explicit unless implicit is estimated at less than half its cost, since at equal cost it is by far the more accurate.
class AutomaticIntegrator final : public Integrator {
 public:
  explicit AutomaticIntegrator(const IntegratorOptions& options);
  AutomaticIntegrator(const AutomaticIntegrator&) = delete;  // chosen_ points into this
  AutomaticIntegrator& operator=(const AutomaticIntegrator&) = delete;

  void rebuild(const Model& model) override;
  StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact, State& state) override {
    return chosen_->step(model, loads, dt, contact, state);
  }
  [[nodiscard]] std::string_view explanation() const override { return explanation_; }
  [[nodiscard]] IntegratorKind kind() const override { return chosen_->kind(); }

 private:
  IntegratorOptions options_;
  ExplicitIntegrator explicit_;
  ImplicitIntegrator implicit_;
  Integrator* chosen_ = &explicit_;
  std::string explanation_;
};

}  // namespace kerf::fem
