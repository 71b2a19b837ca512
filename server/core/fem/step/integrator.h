#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tick_cost.h"
#include "server/core/linear/goes_on.h"
#include "server/core/linear/linear_solver_kind.h"

namespace kerf::fem {

enum StepFlags : std::uint32_t {
  kNoFlags = 0,
  kNotConverged = 1U << 0,   // Newton or the linear solver stopped above its tolerance; the step was still accepted
  kSubstepped = 1U << 1,     // more substeps than planned: a failed attempt was discarded and the step divided
  kSubstepLimit = 1U << 2,   // stability needs more than max_substeps: the step covers less time than dt
  kFrozen = 1U << 3,         // no finite step was found: the state is as it was before
  kRepaired = 1U << 4,       // the fast nonlinear iteration failed; a line-searched one replaced it
  kEnergyLimited = 1U << 5,  // the step would have ended with more energy than it began with: see EnergyGuard
  kWidened = 1U << 6,        // too large, too fast or too flat for mixed precision: made in double
  kDamped = 1U << 7,         // a step of second order failed: implicit Euler replaced it
  kMajorized =
      1U << 8,  // no attempt was finite and kept the energy: one linear step that cannot gain any replaced them
  kInsideBody =
      1U << 9,  // the step began with vertices inside a body, deeper than the sheet is thick: moved out slowly
};

// Names of the flags in metrics and results, in the order of their bits.
inline constexpr std::array<std::string_view, 10> kStepFlagNames{
    "not_converged",  "substepped", "substep_limit", "frozen",    "repaired",
    "energy_limited", "widened",    "damped",        "majorized", "inside_body"};
static_assert(kInsideBody == 1U << (kStepFlagNames.size() - 1));

// Number of steps that reported each flag, by bit.
using FlagCounts = std::array<std::int64_t, kStepFlagNames.size()>;
inline void count_flags(std::uint32_t flags, FlagCounts& counts) {
  for (std::size_t bit = 0; bit < counts.size(); ++bit) counts[bit] += flags >> bit & 1U;
}

inline constexpr double kWorstLinearResidual = 1e6;

// Statistics of a step. Degradation is reported as a value, and the caller decides how to treat it.
struct StepStats {
  std::uint32_t flags = kNoFlags;
  int substeps = 0;
  int newton_iterations = 0;  // summed over substeps
  int linear_iterations = 0;  // summed over Newton iterations
  // Largest relative residual |b - A x| / |b| of a linear solve, recomputed from x; at most kWorstLinearResidual.
  double linear_residual = 0.0;
  double residual = 0.0;    // largest final Newton residual of a substep, relative (see IntegratorOptions); 0: explicit
  double max_strain = 0.0;  // -, largest |principal strain| at the end of the step
  double strained_share = 0.0;  // -, share of the area beyond Material::strain_limit at the end: see StrainExtent
  double simulated = 0.0;       // s, time the state advanced: dt, 0 if frozen, less than dt with kSubstepLimit
  // Number of evaluations of forces on vertices that are neither of the membrane nor linear in positions. These are
  // external forces, wind, follower loads, clamps and a curved rest shape. Implicit integrators count wind only. 0
  // without such forces.
  int load_phases = 0;
  int cluster_pushes = 0;    // number of times that bodies pushed a cluster of local inertia
  int bending_interval = 0;  // explicit: substeps from one kick of bending to the next
  bool is_double = false;    // explicit: made in double precision
  bool interrupted = false;  // stopped early, see Integrator::heed: the state is unchanged, all else is invalid
};

// Clusters of vertices that cuts made stiff: see LocalInertia.
struct LocalInertiaStats {
  int clusters = 0;  // >= 1
  int vertices = 0;  // of all clusters
  int largest = 0;   // vertices of one cluster
  // Least number of substeps of a step with clusters and without them, regardless of the limit.
  double planned_substeps = 0.0;
  double plain_substeps = 0.0;
};

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
  LinearSolverKind linear_solver = LinearSolverKind::kBlockJacobiCg;  // kAutomatic makes its own choice
  CovarianceRootOptions covariance_root;                              // for kEsCgm and kAsCgm
  double linear_tolerance = 1e-4;                                     // -, see linear_solver.h
  int max_linear_iterations = 1000;                                   // per solve by conjugate gradients, >= 1
  int max_halvings = 6;                                               // for a step that fails
};

// Advances a state. Not thread-safe; one for each sheet.
class Integrator {
 public:
  virtual ~Integrator() = default;

  // Must be called before the first step and after every Model::apply or follow. Allocates the memory of step().
  virtual void rebuild(const Model& model) = 0;
  // Updates after exactly one Model::follow since the previous call of rebuild() or follow(). Unchanged parts need not
  // be visited.
  virtual void follow(const Model& model) { rebuild(model); }
  // Must be called once between any number of follow() calls and the next step. Does work that follow() deferred
  // because further cuts would undo it. Allocates the memory of step().
  virtual void prepare() {}
  // Sets the stop condition of later steps, polled once a substep, iteration and front of a factorisation. A stopped
  // step ends early with StepStats::interrupted. Null, the default, means none.
  void heed(const GoesOn* goes_on) { heed_.set(goes_on); }

  // Advances `state` by dt (s, > 0). Never allocates, throws or logs; on failure (kFrozen) `state` is unchanged. The
  // result depends on the arguments alone, not on earlier calls. `contact` may be null.
  virtual StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact,
                         State& state) = 0;

  // 1/kg, velocity of the grab's point per impulse on it, the largest of its components. It is sum of weight^2 / m,
  // unless vertices have another inertia.
  [[nodiscard]] virtual double mobility(const Model& model, const Grab& grab) const;

  // Explains for people which integrator runs and why; valid until the next rebuild.
  [[nodiscard]] virtual std::string_view explanation() const = 0;
  // Integrator that runs; never kAutomatic.
  [[nodiscard]] virtual IntegratorKind kind() const = 0;
  // Clusters and substeps of steps of dt, s. Empty without clusters, as for implicit integrators.
  [[nodiscard]] virtual std::optional<LocalInertiaStats> local_inertia(double /*dt*/) const { return std::nullopt; }
  // Estimates the cost of a step of dt, s, of the model of the last rebuild, after one like `last`; 0 if unknown.
  [[nodiscard]] virtual TickCost expected_cost(const Model& /*model*/, double /*dt*/,
                                               const TickCounts& /*last*/) const {
    return {};
  }

 protected:
  Heed heed_;
};

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options);

}  // namespace kerf::fem
