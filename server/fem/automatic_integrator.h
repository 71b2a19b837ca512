#pragma once

#include <memory>
#include <string>

#include "server/fem/explicit_integrator.h"
#include "server/fem/integrator.h"

namespace kerf::fem {

// Chooses at each rebuild between the explicit integrator and implicit Euler with one of two linear solvers, from the
// model and IntegratorOptions::tick alone: an estimate in nanoseconds, no clock, so the choice is the same on every
// machine. Explicit unless implicit is estimated at less than half its cost, since at equal cost it is by far the more
// accurate.
class AutomaticIntegrator final : public Integrator {
 public:
  explicit AutomaticIntegrator(const IntegratorOptions& options);

  void rebuild(const Model& model) override;
  void follow(const Model& model) override;
  StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact, State& state) override;
  [[nodiscard]] std::string_view explanation() const override { return explanation_; }
  [[nodiscard]] IntegratorKind kind() const override;

 private:
  // Whether the integrator chosen is another one, which knows nothing of the model yet.
  bool choose(const Model& model);
  Integrator& chosen() { return implicit_ ? *implicit_ : explicit_; }

  IntegratorOptions options_;
  LinearSolverKind solver_ = LinearSolverKind::kBlockJacobiCg;  // of the implicit one
  ExplicitIntegrator explicit_;
  std::unique_ptr<Integrator> implicit_;  // null while the explicit integrator is the choice
  std::string explanation_;
};

}  // namespace kerf::fem
