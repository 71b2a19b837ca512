#pragma once

#include <cstdint>

#include "server/base/result.h"
#include "server/core/fem/step/integrator_options.h"
#include "server/core/linear/linear_solver_kind.h"

namespace kerf::sheet {

enum class IntegratorKind {
  kAutomatic,         // see fem::AutomaticIntegrator
  kExplicitLeapfrog,  // stable substeps
  kImplicitEuler,     // Newton iterations; first order, strongly damped
  kTrapezoidal,       // Newton iterations; second order, damps nothing
  kBdf2,              // Newton iterations; second order, damps unresolved frequencies
  kTrBdf2,            // Newton iterations; second order, damps unresolved frequencies
};
using fem::EigenvalueNorm;
using fem::LinearSolverKind;
enum class Precision { kDouble, kMixed };  // explicit: see fem::Precision

struct IntegratorSettings {
  IntegratorKind kind = IntegratorKind::kAutomatic;
  std::int32_t max_substeps = 20000;   // explicit: a tick, 1..100000
  std::int32_t newton_iterations = 2;  // implicit: a solve, 1..100
  double solver_tolerance = 1.0e-4;    // implicit: relative residual of the linear solver, 1e-14..0.1; below 1e-4 of
                                       // Newton's method as well
  LinearSolverKind solver = LinearSolverKind::kBlockJacobiCg;  // implicit; kAutomatic chooses for itself
  std::int32_t max_linear_iterations = 1000;                   // implicit: of a solve by conjugate gradients, 1..100000
  fem::CovarianceRootOptions covariance_root{};                // power 0.01..2, newton_schulz_iterations 1..50
  double highest_mode_damping = 0.05;                          // explicit: -, 0..0.5, see fem::IntegratorOptions
  Precision precision = Precision::kMixed;
};

// Ranges; fields are named as in kerf.v1.Scene ("integrator.max_substeps").
Status validate(const IntegratorSettings& settings);

// vertex_limit() returns the most vertices that a sheet can have with these settings, cuts included.
// check_vertex_limit() fails beyond: kResourceExhausted SOLVER_TOO_DENSE.
std::int32_t vertex_limit(const IntegratorSettings& settings);
Status check_vertex_limit(const IntegratorSettings& settings, std::int32_t num_vertices);

// Converts the settings to the options of `fem`. tick: s, > 0.
fem::IntegratorOptions integrator_options(const IntegratorSettings& settings, double tick);

}  // namespace kerf::sheet
