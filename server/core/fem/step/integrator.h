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
  kNotConverged = 1U << 0,  // Newton or the linear solver stopped above its tolerance; the step was still accepted
  kSubstepped = 1U << 1,    // more substeps than planned: a bad trial was thrown away and the step divided
  kSubstepLimit = 1U << 2,  // stability asks for more than max_substeps: the step covers less time than dt was asked to
  kFrozen = 1U << 3,        // no finite step was found: the state is as it was before
  kRepaired = 1U << 4,      // the fast nonlinear iteration failed; a line-searched one took its place
  kEnergyLimited = 1U << 5,  // the step would have ended with more energy than it began with: see EnergyGuard
  kWidened = 1U << 6,  // the sheet was too large, too fast or a triangle too flat for mixed precision: made in double
  kDamped = 1U << 7,   // a step of second order failed: implicit Euler's took its place
  kMajorized =
      1U << 8,  // no attempt was finite and kept the energy: one linear step that cannot gain any took their place
  kInsideBody =
      1U << 9,  // the step began with vertices inside a body, deeper than the sheet is thick: brought out slowly
};

// In the order of their bits; what metrics and results call them.
inline constexpr std::array<std::string_view, 10> kStepFlagNames{
    "not_converged",  "substepped", "substep_limit", "frozen",    "repaired",
    "energy_limited", "widened",    "damped",        "majorized", "inside_body"};
static_assert(kInsideBody == 1U << (kStepFlagNames.size() - 1));

// Steps that reported each flag, by bit.
using FlagCounts = std::array<std::int64_t, kStepFlagNames.size()>;
inline void count_flags(std::uint32_t flags, FlagCounts& counts) {
  for (std::size_t bit = 0; bit < counts.size(); ++bit) counts[bit] += flags >> bit & 1U;
}

inline constexpr double kWorstLinearResidual = 1e6;

// What a step did. Degradation is a value: the caller decides what it means.
struct StepStats {
  std::uint32_t flags = kNoFlags;
  int substeps = 0;
  int newton_iterations = 0;  // summed over substeps
  int linear_iterations = 0;  // summed over Newton iterations
  // Largest relative residual |b - A x| / |b| of a linear solve, recomputed from x; kWorstLinearResidual stands for
  // anything beyond.
  double linear_residual = 0.0;
  double residual = 0.0;    // largest final Newton residual of a substep, relative (see IntegratorOptions); 0: explicit
  double max_strain = 0.0;  // -, largest |principal strain| at the end of the step
  double strained_share = 0.0;  // -, share of the area beyond Material::strain_limit then: see StrainExtent
  double simulated = 0.0;       // s, time the state advanced: dt, 0 when frozen, less than dt with kSubstepLimit
  // Times that forces on vertices were summed that are neither of the membrane nor linear in positions: external ones,
  // wind, follower loads, clamps, a curved rest shape. Of implicit integrators, of wind alone. 0 where there are none.
  int load_phases = 0;
  int cluster_pushes = 0;    // times that bodies pushed a cluster of local inertia
  int bending_interval = 0;  // explicit: substeps from one kick of bending to the next
  bool is_double = false;    // explicit: made in double precision
  bool interrupted = false;  // ended early, see Integrator::heed: the state is as it was before, nothing else holds
};

// Clusters of vertices that cuts made stiff: see LocalInertia.
struct LocalInertiaStats {
  int clusters = 0;  // >= 1
  int vertices = 0;  // of all clusters
  int largest = 0;   // vertices of one cluster
  // Substeps a step takes at least, and how many it would take without clusters, whatever the limit is.
  double planned_substeps = 0.0;
  double plain_substeps = 0.0;
};

enum class IntegratorKind {
  kAutomatic,      // explicit, TR-BDF2 or implicit Euler: see automatic_integrator.h
  kExplicit,       // velocity Verlet (leapfrog) with stable substeps: second order, symplectic, hardly any damping
  kImplicitEuler,  // first order, strongly damped, robust
  kTrBdf2,         // trapezoidal rule + BDF2, second order, L-stable; two solves a step
  kTrapezoidal,  // second order, conserves the energy of a linear sheet, damps nothing: what it does not resolve rings
  kBdf2,         // second order, L-stable; kBdf2Substeps solves a step. Begins anew each step, no state having history:
                 // the first substep is of the trapezoidal rule
};

inline constexpr int kBdf2Substeps = 4;  // a step

enum class Precision {
  kDouble,
  kMixed,  // explicit only: float arithmetic and velocities, fixed-point positions; see LeapfrogSweep
};

struct IntegratorOptions {
  IntegratorKind kind = IntegratorKind::kAutomatic;
  double tick = 1.0 / 60.0;  // s, the dt that step() will be called with; kAutomatic's estimate only

  // Explicit. Substep <= cfl * stable step; at most 0.7 of it without damping.
  double cfl = 0.95;                   // -, (0, 1)
  double highest_mode_damping = 0.05;  // -, [0, 0.5]: damping ratio of the fastest mode, added as Kelvin-Voigt damping;
                                       // no less than 0.05 of the sheet as built where cuts have made clusters.
                                       // Upper limit of the material's own stiffness_damping as well. Without any, the
                                       // scheme may gain energy in a crumpled sheet
  int max_substeps = 20000;            // a step
  bool has_local_inertia = true;       // of what cuts leave much stiffer than the sheet as built: see LocalInertia
  Precision precision = Precision::kMixed;  // kMixed: a step that floats cannot hold is made in double (kWidened), and
                                            // one of a sheet nearly at rest near bodies

  // Implicit.
  int newton_iterations = 5;       // a substep, >= 1
  double newton_tolerance = 1e-4;  // -, stop when |r| <= tolerance * scale, r the residual M dx - h^2 f of the step
                                   // (kg m), scale the same for ballistic motion, but no less than 1e-3 of that of
                                   // standing still, nor than what rounding leaves
  LinearSolverKind linear_solver = LinearSolverKind::kBlockJacobiCg;  // kAutomatic chooses for itself
  CovarianceRootOptions covariance_root;                              // of kEsCgm and kAsCgm
  double linear_tolerance = 1e-4;                                     // -, see linear_solver.h
  int max_linear_iterations = 1000;                                   // of one solve by conjugate gradients, >= 1
  int max_halvings = 6;                                               // of a step that fails
};

// Advances a state. Not thread-safe; one a sheet.
class Integrator {
 public:
  virtual ~Integrator() = default;

  // To be called before the first step and after every Model::apply or follow. Allocates what step() needs.
  virtual void rebuild(const Model& model) = 0;
  // The same where the last Model::follow is all that has changed since the call before, of either: what that left
  // alone need not be looked at.
  virtual void follow(const Model& model) { rebuild(model); }
  // To be called between follow() and the next step, once for however many: what follow() put off till then, because
  // further cuts would undo it. Allocates what step() needs.
  virtual void prepare() {}
  // Steps to come ask `goes_on` once a substep, iteration and front of a factorisation, and end early, with
  // StepStats::interrupted, where it says so. Null, as at first: they ask nobody.
  void heed(const GoesOn* goes_on) { heed_.set(goes_on); }

  // Advances `state` by dt (s, > 0). Never allocates, throws or logs; on failure (kFrozen) `state` is left as it was.
  // The result depends on the arguments alone, not on earlier calls. `contact` may be null.
  virtual StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact,
                         State& state) = 0;

  // 1/kg, what an impulse at the grab's point moves it by, the largest of its components: sum of weight^2 / m, but
  // where vertices have another inertia.
  [[nodiscard]] virtual double mobility(const Model& model, const Grab& grab) const;

  // What steps here and why, for people; valid until the next rebuild.
  [[nodiscard]] virtual std::string_view explanation() const = 0;
  // What runs: never kAutomatic.
  [[nodiscard]] virtual IntegratorKind kind() const = 0;
  // Clusters and substeps of steps of dt, s. Nothing where there are no clusters, as of implicit integrators.
  [[nodiscard]] virtual std::optional<LocalInertiaStats> local_inertia(double /*dt*/) const { return std::nullopt; }
  // Counts what a step of dt, s, of the model of the last rebuild takes after one like `last`; 0 where unknown.
  [[nodiscard]] virtual TickCost expected_cost(const Model& /*model*/, double /*dt*/,
                                               const TickCounts& /*last*/) const {
    return {};
  }

 protected:
  Heed heed_;
};

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options);

}  // namespace kerf::fem
