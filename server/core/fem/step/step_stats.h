#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

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
  kIntersects = 1U << 10,  // the step ended with triangles that pass through each other, though self-contact is on
  // Contact of the sheet with itself corrected an implicit step after its solve, whose equations do not know of it.
  kSplitContact = 1U << 11,
};

// Names of the flags in metrics and results, in the order of their bits.
inline constexpr std::array<std::string_view, 12> kStepFlagNames{
    "not_converged", "substepped", "substep_limit", "frozen",      "repaired",   "energy_limited",
    "widened",       "damped",     "majorized",     "inside_body", "intersects", "split_contact"};
static_assert(kSplitContact == 1U << (kStepFlagNames.size() - 1));

// Number of steps that reported each flag, by bit.
using FlagCounts = std::array<std::int64_t, kStepFlagNames.size()>;
inline void count_flags(std::uint32_t flags, FlagCounts& counts) {
  for (std::size_t bit = 0; bit < counts.size(); ++bit) counts[bit] += flags >> bit & 1U;
}

inline constexpr double kWorstLinearResidual = 1e6;

// Contact of a sheet with itself in a step; see contact::SelfContact.
struct SelfContactStats {
  std::int64_t phases = 0;     // between substeps in which pairs of features were looked at
  std::int64_t searches = 0;   // lists of pairs that may touch
  std::int64_t late = 0;       // lists that were too old before the next phase, and were made again for the past
  std::int64_t pairs = 0;      // listed, summed over searches
  std::int64_t contacts = 0;   // pairs that responded, summed over phases
  std::int64_t repairs = 0;    // pairs that would have passed through each other, put right one by one
  std::int64_t zones = 0;      // such pairs that were moved as one with their neighbours
  std::int64_t unsettled = 0;  // such pairs that were left
  // Pairs of triangles that pass through each other at the end; 0 without self-contact.
  std::int64_t intersections = 0;

  SelfContactStats& operator+=(const SelfContactStats& other) {
    phases += other.phases;
    searches += other.searches;
    late += other.late;
    pairs += other.pairs;
    contacts += other.contacts;
    repairs += other.repairs;
    zones += other.zones;
    unsettled += other.unsettled;
    intersections += other.intersections;
    return *this;
  }
};

// Statistics of a step. A step that went wrong is reported by flags, and the caller decides how to treat it.
struct StepStats {
  std::uint32_t flags = kNoFlags;
  int substeps = 0;
  int newton_iterations = 0;  // summed over substeps
  int linear_iterations = 0;  // summed over Newton iterations
  // Largest relative residual |b - A x| / |b| of a linear solve, recomputed from x; at most kWorstLinearResidual.
  double linear_residual = 0.0;
  double residual = 0.0;        // -, largest final Newton residual of any substep, relative to the scale at
                                // IntegratorOptions::newton_tolerance; 0 for explicit steps
  double max_strain = 0.0;      // -, largest |principal strain| at the end of the step
  double strained_share = 0.0;  // -, StrainExtent::beyond_limit at the end of the step
  double simulated = 0.0;       // s, time the state advanced: dt, 0 if frozen, less than dt with kSubstepLimit
  // Number of times that forces were evaluated which are neither those of the membrane nor linear in positions. These
  // are external forces, wind, follower loads, clamps and a curved rest shape. Implicit integrators count wind only. 0
  // if none of these forces acts.
  int load_phases = 0;
  int cluster_pushes = 0;    // number of times that bodies pushed a cluster of local inertia
  int bending_interval = 0;  // explicit: substeps from one kick of bending to the next
  bool is_double = false;    // explicit: made in double precision
  SelfContactStats self_contact;
  bool interrupted =
      false;  // stopped early, see Integrator::set_stop_condition: the state is unchanged, all else is invalid
};

// Clusters of vertices that cuts made stiff: see LocalInertia.
struct LocalInertiaStats {
  int clusters = 0;  // >= 1
  int vertices = 0;  // of all clusters
  int largest = 0;   // vertices of one cluster
  // Least number of substeps of a step with clusters (planned) and without them (plain), regardless of max_substeps.
  double planned_substeps = 0.0;
  double plain_substeps = 0.0;
};

}  // namespace kerf::fem
