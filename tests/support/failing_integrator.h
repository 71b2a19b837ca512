#pragma once

#include <limits>
#include <memory>
#include <new>
#include <utility>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/integrator.h"

namespace kerf::scenes {

inline constexpr double kGivesUp = 66.0;         // m/s^2: gravity along z with which a step reports kFrozen
inline constexpr double kRunsShort = 88.0;       // m/s^2: gravity along z with which memory runs out in a step
inline constexpr double kWritesNonsense = 77.0;  // m/s^2: gravity along z with which a step writes NaN as success

// Wraps a real integrator and fails if gravity has one of the values above. A step thus still depends only on its
// arguments.
class FailingIntegrator : public fem::Integrator {
 public:
  explicit FailingIntegrator(const fem::IntegratorOptions& options) : inner_(fem::make_integrator(options)) {}

  void rebuild(const fem::Model& model) override { inner_->rebuild(model); }
  fem::StepStats step(const fem::Model& model, const fem::Loads& loads, double dt, fem::ContactConstraint* contact,
                      fem::State& state) override {
    if (loads.gravity.z() == kGivesUp) {
      fem::StepStats stats;
      stats.flags = fem::kFrozen;
      return stats;
    }
    inner_->set_stop_condition(stop_.get());
    if (loads.gravity.z() == kRunsShort) {
      state.x.setZero();
      throw std::bad_alloc();
    }
    fem::StepStats stats = inner_->step(model, loads, dt, contact, state);
    if (loads.gravity.z() == kWritesNonsense) state.v(1, 0) = std::numeric_limits<double>::quiet_NaN();
    return stats;
  }
  [[nodiscard]] std::string_view explanation() const override { return inner_->explanation(); }
  [[nodiscard]] fem::IntegratorKind kind() const override { return inner_->kind(); }

 private:
  std::unique_ptr<fem::Integrator> inner_;
};

inline std::unique_ptr<fem::Integrator> make_failing_integrator(const fem::IntegratorOptions& options) {
  return std::make_unique<FailingIntegrator>(options);
}

}  // namespace kerf::scenes
