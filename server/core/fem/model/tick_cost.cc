#include "server/core/fem/model/tick_cost.h"

#include <algorithm>
#include <cmath>

namespace kerf::fem {
namespace {

// Nanoseconds on one core of 2024. Fitted to ticks of wool of 625 to 16,000 vertices, uncut and after 1 to 100 random
// cuts, within a sixth of each. Ticks of demo, cotton and silk agree.
struct ExplicitCost {
  double per_slot;
  double per_bending_entry;
};
constexpr ExplicitCost kDoubleNs{4.0, 1.3};
constexpr ExplicitCost kMixedNs{1.9, 0.63};
constexpr double kNsPerCluster = 230.0;
constexpr double kNsPerClusterEntry = 1.0;  // per entry of a factor below its diagonal
constexpr double kNsPerContactBlock = 130.0;
constexpr double kNsPerClusterPush = 1200.0;
constexpr double kNsPerSlotOfLoads = 28.0;
constexpr double kNsPerVertex = 50.0;  // once a tick: reading and writing the state, strain, energy, rest
// Substeps cost more when their data exceeds the cache: fitted to 10,000 to 160,000 vertices.
constexpr double kBytesPerSlot = 37.0;
constexpr double kBytesPerBendingEntry = 8.0;
constexpr double kCacheBytes = 15e6;  // bytes per substep at which waiting for memory costs as much as the arithmetic

constexpr double kTangentNsPerSlot = 250.0;
// Factorising a planar mesh of V vertices costs V^1.5 (George 1973, nested dissection). Cuts hardly lengthen the
// separators. A float factor is kept as long as it serves, which is longer the more it costs.
struct SystemCost {
  double per_vertex_to_three_halves;  // of the sheet as built
  double per_new_vertex;
};
constexpr SystemCost kDirectNs{80.0, 800.0};
constexpr SystemCost kKeptNs{40.0, 3200.0};
constexpr double kMostToThreeHalves = 20'000.0;  // vertices: above, the cost of a kept float factor grows as V
constexpr double kNsPerSlotAndIteration = 20.0;  // of conjugate gradients
constexpr double kExpectedIterations = 50.0;     // of a system, before the first tick

// Fitted to ticks of 490 to 2,700 vertices that touch themselves nowhere, in folds and in layers.
constexpr double kNsPerVertexAndPhase = 75.0;
constexpr double kNsPerVertexAndSearch = 75.0;
constexpr double kNsPerPair = 310.0;
constexpr double kNsPerSelfContact = 130.0;
constexpr double kNsPerRepair = 3000.0;

double self_contact_ns(double vertices, const SelfContactCounts& counts) {
  return vertices * (kNsPerVertexAndPhase * counts.phases + kNsPerVertexAndSearch * counts.searches) +
         kNsPerPair * counts.pairs + kNsPerSelfContact * counts.contacts + kNsPerRepair * counts.repairs;
}

}  // namespace

SelfContactCounts expected_self_contact(double substeps, double vertices) {
  constexpr double kPartsOfImplicit = 64.0;  // of an implicit step, see SelfContactCorrection
  constexpr double kIdleInterval = 16.0;     // substeps between phases while nothing is near, see contact::SelfContact
  constexpr double kTouchingShare = 0.1;     // -, of the vertices
  SelfContactCounts counts;
  counts.phases = 1.0 + std::ceil((substeps > 0.0 ? substeps : kPartsOfImplicit) / kIdleInterval);
  counts.searches = counts.phases;
  counts.pairs = counts.contacts = kTouchingShare * vertices * counts.phases;
  return counts;
}

TickCost cost_of(const ExplicitCounts& counts, const TickCounts& last) {
  const ExplicitCost ns = counts.is_double ? kDoubleNs : kMixedNs;
  const double interval = std::max(counts.bending_interval / std::max(last.more_kicks, 1.0), 1.0);
  const double entries = counts.bending_entries / interval;
  const double substeps = counts.substeps * std::max(last.more_substeps, 1.0);
  const double beyond_cache = 1.0 + (kBytesPerSlot * counts.slots + kBytesPerBendingEntry * entries) / kCacheBytes;
  TickCost cost;
  cost.substeps = substeps;
  cost.bending_interval = interval;
  cost[TickPart::kMembrane] = kNsPerVertex * counts.vertices + substeps * beyond_cache * ns.per_slot * counts.slots;
  cost[TickPart::kBending] = substeps * beyond_cache * ns.per_bending_entry * entries;
  cost[TickPart::kClusters] =
      substeps * (kNsPerCluster * counts.clusters + kNsPerClusterEntry * counts.cluster_entries);
  const double pushes = counts.clusters > 0.0 ? last.cluster_pushes : 0.0;
  cost[TickPart::kContact] = substeps * (kNsPerContactBlock * last.contact_blocks + kNsPerClusterPush * pushes);
  cost[TickPart::kLoads] = substeps * last.load_phases * kNsPerSlotOfLoads * counts.slots;
  cost[TickPart::kSelfContact] = self_contact_ns(counts.vertices, last.self_contact);
  return cost;
}

TickCost cost_of(const ImplicitCounts& counts, const TickCounts& last) {
  // A cut adds about as many slots as vertices; uncut meshes have twice as many.
  const double built = std::clamp(counts.slots - counts.vertices, 1.0, std::max(counts.vertices, 1.0));
  const double added = counts.vertices - built;
  const double newton = last.newton_iterations > 0.0 ? last.newton_iterations : counts.most_newton_iterations;
  double per_system = 0.0;
  switch (counts.solver) {
    case SystemSolver::kDirect:
      per_system = kDirectNs.per_vertex_to_three_halves * built * std::sqrt(built) + kDirectNs.per_new_vertex * added;
      break;
    case SystemSolver::kKeptFactor:
      per_system = kKeptNs.per_vertex_to_three_halves * built * std::sqrt(std::min(built, kMostToThreeHalves)) +
                   kKeptNs.per_new_vertex * added;
      break;
    case SystemSolver::kIterative:
      per_system =
          kNsPerSlotAndIteration * counts.slots *
          (last.newton_iterations > 0.0 ? last.linear_iterations / last.newton_iterations : kExpectedIterations);
      break;
  }
  TickCost cost;
  cost[TickPart::kMembrane] = newton * kTangentNsPerSlot * counts.slots;
  cost[TickPart::kSolve] = newton * per_system;
  cost[TickPart::kSelfContact] = self_contact_ns(counts.vertices, last.self_contact);
  return cost;
}

}  // namespace kerf::fem
