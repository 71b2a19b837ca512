#pragma once

#include "server/core/linear/linear_solver_kind.h"

namespace kerf::fem {

enum class IntegratorKind {
  kAutomatic,      // explicit, TR-BDF2 or SDIRK2: see automatic_integrator.h
  kExplicit,       // velocity Verlet (leapfrog) with stable substeps: second order, symplectic, hardly any damping
  kImplicitEuler,  // first order, strongly damped, robust
  kTrBdf2,         // trapezoidal rule + BDF2, second order, L-stable; two solves a step
  kTrapezoidal,    // second order, conserves the energy of a linear sheet, no damping: unresolved modes ring
  kBdf2,    // second order, L-stable; kBdf2Substeps solves a step. Restarts each step with a trapezoidal substep,
            // because the state has no history
  kSdirk2,  // second order, L-stable; two solves a step. Equals TR-BDF2 for linear sheets, without using the forces at
            // the start of the step. Scenes cannot ask for it, kAutomatic takes it
};

inline constexpr int kBdf2Substeps = 4;  // per step

// Versions of what kAutomatic chooses, see automatic_integrator.h.
enum class AutomaticChoice { kFirst, kSecond };

enum class Precision {
  kDouble,
  kMixed,  // explicit only: float arithmetic and velocities, fixed-point positions; see LeapfrogSweep
};

struct IntegratorOptions {
  IntegratorKind kind = IntegratorKind::kAutomatic;
  double tick = 1.0 / 60.0;  // s, the dt that step() will be called with; only for kAutomatic's estimate
  AutomaticChoice choice = AutomaticChoice::kSecond;
  bool touches_itself = false;  // true: kAutomatic prefers explicit steps, whose self-contact is the more accurate

  // Explicit steps. A substep is at most cfl times the stable step, and without damping at most 0.7 times it.
  double cfl = 0.95;  // -, (0, 1)
  // -, [0, 0.5]: least damping ratio of the fastest mode, by Kelvin-Voigt damping. Material::stiffness_damping may
  // raise the ratio further, up to ExplicitIntegrator::kMaxModeDamping. If cuts have made clusters it counts as at
  // least 0.05, for the fastest mode of the sheet as built. Without damping the scheme may gain energy in a crumpled
  // sheet.
  double highest_mode_damping = 0.05;
  int max_substeps = 20000;       // per step
  bool has_local_inertia = true;  // true: clusters for parts that cuts leave much stiffer than the sheet as built,
                                  // see LocalInertia
  // With kMixed, steps that floats cannot hold are made in double (kWidened). Steps of a sheet nearly at rest are made
  // in double if displacements cannot represent them, as with Green's strain.
  Precision precision = Precision::kMixed;

  // Implicit steps.
  int newton_iterations = 5;  // per substep, >= 1
  // -, Newton's method stops when |r| <= newton_tolerance * scale. r is the residual M dx - h^2 f of the step (kg m).
  // The scale is |r| for ballistic motion, but at least 1e-3 of |r| for no motion at all. It is also so large that
  // rounding of r is below the tolerance. Beside bodies |r| is also at most 1 % of friction, or a few more iterations
  // are made.
  double newton_tolerance = 1e-4;
  linear::LinearSolverKind linear_solver = linear::LinearSolverKind::kBlockJacobiCg;  // kAutomatic makes its own choice
  linear::CovarianceRootOptions covariance_root;                                      // for kEsCgm and kAsCgm
  double linear_tolerance = 1e-4;                                                     // -, see linear_solver.h
  int max_linear_iterations = 1000;  // per solve by conjugate gradients, >= 1
  int max_halvings = 6;              // most halvings of a step that fails
};

}  // namespace kerf::fem
