#pragma once

#include "server/core/linear/linear_solver_kind.h"

namespace kerf::fem {

enum class IntegratorKind {
  kAutomatic,      // explicit, TR-BDF2 or implicit Euler: see automatic_integrator.h
  kExplicit,       // velocity Verlet (leapfrog) with stable substeps: second order, symplectic, hardly any damping
  kImplicitEuler,  // first order, strongly damped, robust
  kTrBdf2,         // trapezoidal rule + BDF2, second order, L-stable; two solves a step
  kTrapezoidal,    // second order, conserves the energy of a linear sheet, no damping: unresolved modes ring
  kBdf2,  // second order, L-stable; kBdf2Substeps solves a step. Restarts each step with a trapezoidal substep,
          // because the state has no history
};

inline constexpr int kBdf2Substeps = 4;  // per step

enum class Precision {
  kDouble,
  kMixed,  // explicit only: float arithmetic and velocities, fixed-point positions; see LeapfrogSweep
};

struct IntegratorOptions {
  IntegratorKind kind = IntegratorKind::kAutomatic;
  double tick = 1.0 / 60.0;  // s, the dt that step() will be called with; only for kAutomatic's estimate

  // Explicit. Substep <= cfl * stable step, and at most 0.7 of it without damping.
  double cfl = 0.95;                   // -, (0, 1)
  double highest_mode_damping = 0.05;  // -, [0, 0.5]: damping ratio of the fastest mode, added as Kelvin-Voigt damping.
                                       // It is at least 0.05 of the sheet as built if cuts have made clusters. It also
                                       // limits the material's own stiffness_damping from above. Without damping the
                                       // scheme may gain energy in a crumpled sheet
  int max_substeps = 20000;            // per step
  bool has_local_inertia = true;       // for parts that cuts leave much stiffer than the sheet as built: see
                                       // LocalInertia
  Precision precision = Precision::kMixed;  // kMixed: steps that floats cannot hold are made in double (kWidened). So
                                            // are those of a sheet nearly at rest that displacements cannot represent,
                                            // as with Green's strain

  // Implicit.
  int newton_iterations = 5;       // per substep, >= 1
  double newton_tolerance = 1e-4;  // -, stop when |r| <= tolerance * scale, with r the residual M dx - h^2 f of the
                                   // step (kg m). The scale is |r| for ballistic motion, at least 1e-3 of that for
                                   // standing still, and so large that rounding is below the tolerance
  linear::LinearSolverKind linear_solver = linear::LinearSolverKind::kBlockJacobiCg;  // kAutomatic makes its own choice
  linear::CovarianceRootOptions covariance_root;                                      // for kEsCgm and kAsCgm
  double linear_tolerance = 1e-4;                                                     // -, see linear_solver.h
  int max_linear_iterations = 1000;  // per solve by conjugate gradients, >= 1
  int max_halvings = 6;              // for a step that fails
};

}  // namespace kerf::fem
