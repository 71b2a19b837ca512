#include "server/sheet/integrator_settings.h"

#include <algorithm>

#include "server/sheet/field_checks.h"

namespace kerf::sheet {

Status validate(const IntegratorSettings& settings) {
  if (Status s = check_integer(settings.max_substeps, 1, 100'000, "integrator.max_substeps"); !s) return s;
  if (Status s = check_integer(settings.newton_iterations, 1, 100, "integrator.newton_iterations"); !s) return s;
  if (Status s = check_number(settings.solver_tolerance, 1.0e-14, 0.1, "integrator.solver_tolerance"); !s) return s;
  if (Status s = check_integer(settings.max_linear_iterations, 1, 1'000'000, "integrator.max_linear_iterations"); !s) {
    return s;
  }
  return check_number(settings.highest_mode_damping, 0.0, 0.5, "integrator.highest_mode_damping");
}

fem::IntegratorOptions integrator_options(const IntegratorSettings& settings, double tick) {
  fem::IntegratorOptions options;
  switch (settings.kind) {
    case IntegratorKind::kAutomatic:
      options.kind = fem::IntegratorKind::kAutomatic;
      break;
    case IntegratorKind::kExplicitLeapfrog:
      options.kind = fem::IntegratorKind::kExplicit;
      break;
    case IntegratorKind::kImplicitEuler:
      options.kind = fem::IntegratorKind::kImplicitEuler;
      break;
    case IntegratorKind::kTrapezoidal:
      options.kind = fem::IntegratorKind::kTrapezoidal;
      break;
    case IntegratorKind::kBdf2:
      options.kind = fem::IntegratorKind::kBdf2;
      break;
    case IntegratorKind::kTrBdf2:
      options.kind = fem::IntegratorKind::kTrBdf2;
      break;
  }
  options.tick = tick;
  options.max_substeps = settings.max_substeps;
  options.newton_iterations = settings.newton_iterations;
  options.highest_mode_damping = settings.highest_mode_damping;
  options.precision = settings.precision == Precision::kMixed ? fem::Precision::kMixed : fem::Precision::kDouble;
  options.linear_tolerance = settings.solver_tolerance;
  options.newton_tolerance = std::min(options.newton_tolerance, settings.solver_tolerance);
  options.linear_solver = settings.solver;
  options.max_linear_iterations = settings.max_linear_iterations;
  return options;
}

}  // namespace kerf::sheet
