#include "server/fem/automatic_integrator.h"

#include <algorithm>
#include <cmath>

#include "server/fem/stable_step.h"

namespace kerf::fem {
namespace {

// Nanoseconds on one core of 2024, two-lane vectors; only their ratios matter.
constexpr double kForceNsPerSlot = 30.0;
constexpr double kForceNsPerBendingEntry = 1.3;
constexpr double kTangentNsPerSlot = 600.0;
constexpr double kProductNsPerBlock = 5.0;
// Conjugate gradient iterations for sqrt(condition number) 1: block-Jacobi needed 0.25 (stiff) to 1.1 (soft).
constexpr double kIterationsPerRootCondition = 0.6;
constexpr double kPreferenceForExplicit = 2.0;

IntegratorOptions with_kind(IntegratorOptions options, IntegratorKind kind) {
  options.kind = kind;
  return options;
}

double explicit_cost(const Model& model, double substeps) {
  const auto entries = static_cast<double>(model.bending_rows().num_entries());
  return substeps * (kForceNsPerSlot * model.num_slots() + kForceNsPerBendingEntry * entries);
}

double implicit_cost(const Model& model, const IntegratorOptions& options) {
  const double root_condition = std::sqrt(1.0 + options.tick * options.tick * stiffness_bound(model));
  const double iterations =
      std::min(kIterationsPerRootCondition * root_condition, static_cast<double>(options.max_linear_iterations));
  const double blocks = std::max(static_cast<double>(model.bending_rows().num_entries()), 7.0 * model.num_vertices());
  return options.newton_iterations * (kTangentNsPerSlot * model.num_slots() + iterations * kProductNsPerBlock * blocks);
}

std::string milliseconds(double nanoseconds) {
  return std::to_string(nanoseconds * 1e-6) + " ms";
}

}  // namespace

AutomaticIntegrator::AutomaticIntegrator(const IntegratorOptions& options)
    : options_(options),
      explicit_(with_kind(options, IntegratorKind::kExplicit)),
      implicit_(with_kind(options, IntegratorKind::kImplicitEuler)) {}

void AutomaticIntegrator::rebuild(const Model& model) {
  explicit_.rebuild(model);
  const double substeps = explicit_.planned_substeps(options_.tick);
  const double cost_explicit = explicit_cost(model, substeps);
  const double cost_implicit = implicit_cost(model, options_);
  const bool fits = substeps <= options_.max_substeps;
  const bool use_explicit = fits && cost_explicit <= kPreferenceForExplicit * cost_implicit;
  chosen_ = &explicit_;
  if (!use_explicit) {
    implicit_.rebuild(model);
    chosen_ = &implicit_;
  }
  explanation_ = "automatic: " + std::string(use_explicit ? "explicit" : "implicit Euler") + ", because a tick takes " +
                 std::to_string(static_cast<std::int64_t>(substeps)) + " stable substeps, about " +
                 milliseconds(cost_explicit) + ", or an implicit step of about " + milliseconds(cost_implicit);
}

}  // namespace kerf::fem
