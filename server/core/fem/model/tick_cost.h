#pragma once

#include <array>
#include <cstddef>
#include <numeric>
#include <string_view>

namespace kerf::fem {

// Parts of a tick to which its time is attributed.
enum class TickPart {
  kMembrane,  // forces of stretching and shearing; in explicit steps also the motion of vertices
  kBending,
  kClusters,     // motion of the clusters of LocalInertia around tiny triangles
  kContact,      // keeping vertices out of bodies
  kLoads,        // forces summed vertex by vertex: wind, follower loads, external forces
  kSolve,        // linear systems of implicit steps
  kSelfContact,  // keeping folds and pieces of the sheet apart
};
inline constexpr std::array<std::string_view, 7> kTickPartNames{"membrane", "bending", "clusters",    "contact",
                                                                "loads",    "solve",   "self_contact"};

// Time of a tick estimated from counts alone, the same on every machine. It is in ns on one core of 2024, within 1.5
// times of measured ticks (tests/bench/notes/tick-estimate.md).
struct TickCost {
  double substeps = 0.0;                           // per tick; 0 for implicit steps
  double bending_interval = 1.0;                   // substeps from one kick of bending to the next
  std::array<double, kTickPartNames.size()> ns{};  // by part, >= 0

  [[nodiscard]] double& operator[](TickPart part) { return ns[static_cast<std::size_t>(part)]; }
  [[nodiscard]] double operator[](TickPart part) const { return ns[static_cast<std::size_t>(part)]; }
  [[nodiscard]] double total() const { return std::accumulate(ns.begin(), ns.end(), 0.0); }
};

// Counts of what keeps the sheet from passing through itself, in a tick; 0 without self-contact. See SelfContactStats.
struct SelfContactCounts {
  double phases = 0.0;
  double searches = 0.0;
  double pairs = 0.0;     // listed, summed over searches
  double contacts = 0.0;  // summed over phases
  double repairs = 0.0;
};
// Returns the counts to assume of a sheet that has made no tick: nothing touches, so it is looked at once in a while,
// and an allowance for what may touch soon, a tenth of the vertices. `substeps`: of a tick; 0 for implicit steps.
SelfContactCounts expected_self_contact(double substeps, double vertices);

// Counts of the last tick that cannot be derived from a model. Before the first tick they have the values below.
struct TickCounts {
  double contact_blocks = 0.0;     // blocks of mesh::kVertexLanes vertices that contact checks per substep
  double cluster_pushes = 0.0;     // pushes of clusters by bodies per substep
  double load_phases = 0.0;        // per substep, see StepStats::load_phases
  double more_substeps = 1.0;      // -, ratio to the substeps planned for the sheet at rest; stretched sheets take more
  double more_kicks = 1.0;         // -, ratio of bending kicks to those planned for the sheet at rest
  bool is_double = false;          // stepped in double precision
  double newton_iterations = 0.0;  // per tick; 0 assumes the maximum
  double linear_iterations = 0.0;  // per tick; 0 assumes the maximum
  SelfContactCounts self_contact{};
};

// Counts of an explicit step.
struct ExplicitCounts {
  double substeps = 0.0;
  double bending_interval = 1.0;  // substeps from one kick of bending to the next
  double slots = 0.0;             // of triangles
  double bending_entries = 0.0;   // of the bending matrix
  double vertices = 0.0;
  double clusters = 0.0;
  double cluster_entries = 0.0;  // of the clusters' factors
  bool is_double = false;
};
TickCost cost_of(const ExplicitCounts& counts, const TickCounts& last);

enum class SystemSolver { kDirect, kKeptFactor, kIterative };
// Counts of an implicit step.
struct ImplicitCounts {
  double most_newton_iterations = 0.0;  // of the tick
  double vertices = 0.0;
  double slots = 0.0;
  SystemSolver solver = SystemSolver::kDirect;
};
TickCost cost_of(const ImplicitCounts& counts, const TickCounts& last);

}  // namespace kerf::fem
