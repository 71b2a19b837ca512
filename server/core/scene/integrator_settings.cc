#include "server/core/scene/integrator_settings.h"

#include <algorithm>
#include <string>

#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/field_checks.h"

namespace kerf::scene {

Status validate(const IntegratorSettings& settings) {
  KERF_TRY(check_integer(settings.max_substeps, 1, 100'000, "integrator.max_substeps"));
  KERF_TRY(check_integer(settings.newton_iterations, 1, 100, "integrator.newton_iterations"));
  KERF_TRY(check_number(settings.solver_tolerance, 1.0e-14, 0.1, "integrator.solver_tolerance"));
  KERF_TRY(check_integer(settings.max_linear_iterations, 1, 100'000, "integrator.max_linear_iterations"));
  KERF_TRY(check_integer(settings.choice, kFirstChoice, kNewestChoice, "integrator.choice"));
  const linear::CovarianceRootOptions& root = settings.covariance_root;
  KERF_TRY(check_number(root.power, 0.01, 2.0, "integrator.covariance_root.p"));
  KERF_TRY(check_integer(root.newton_schulz_iterations, 1, 50, "integrator.covariance_root.newton_schulz_iterations"));
  return check_number(settings.highest_mode_damping, 0.0, 0.5, "integrator.highest_mode_damping");
}

bool is_implicit(IntegratorKind kind) {
  return kind != IntegratorKind::kAutomatic && kind != IntegratorKind::kExplicitLeapfrog;
}

std::int32_t vertex_limit(const IntegratorSettings& settings) {
  const bool is_dense = is_implicit(settings.kind) && linear::name_of(settings.solver).solves_different_system;
  return is_dense ? linear::kMaxCovarianceVertices : mesh::kMaxVertices;
}

Status check_vertex_limit(const IntegratorSettings& settings, std::int32_t num_vertices) {
  const std::int32_t limit = vertex_limit(settings);
  if (num_vertices <= limit) return Nothing{};
  return resource_exhausted("SOLVER_TOO_DENSE",
                            "the sheet has " + std::to_string(num_vertices) +
                                " vertices; ES_CGM and AS_CGM build dense matrices, for " + std::to_string(limit) +
                                " at most: choose another integrator.solver or a coarser mesh",
                            "integrator.solver");
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
  options.choice = settings.choice == kFirstChoice ? fem::AutomaticChoice::kFirst : fem::AutomaticChoice::kSecond;
  options.max_substeps = settings.max_substeps;
  options.newton_iterations = settings.newton_iterations;
  options.highest_mode_damping = settings.highest_mode_damping;
  options.precision = settings.precision == Precision::kMixed ? fem::Precision::kMixed : fem::Precision::kDouble;
  options.linear_tolerance = settings.solver_tolerance;
  options.newton_tolerance = std::min(options.newton_tolerance, settings.solver_tolerance);
  options.linear_solver = settings.solver;
  options.max_linear_iterations = settings.max_linear_iterations;
  options.covariance_root = settings.covariance_root;
  // A dense solve takes up to seconds, so a step is not divided, which would need up to 2^max_halvings solves.
  if (linear::name_of(settings.solver).solves_different_system) options.max_halvings = 0;
  return options;
}

fem::IntegratorOptions integrator_options(const SheetConfig& config, bool touches_itself) {
  fem::IntegratorOptions options = integrator_options(config.integrator, 1.0 / config.tick_rate_hz);
  options.touches_itself = touches_itself;
  return options;
}

}  // namespace kerf::scene
