// Constraints and loads in force, and the equilibria that they lead to.

#include <utility>

#include "server/core/sheet/sheet_impl.h"

namespace kerf::sheet {

void Sheet::Impl::set_conditions(const Instant& end, double duration) {
  const bool varies = held_vertices.varies() || applied_forces.varies() || !config->gravity_history.times.empty();
  if (!conditions_changed && !varies && end.absent == now.absent) return;
  loads.gravity = config->gravity_history.at(end.time, 1.0) * full_gravity;
  if (held_vertices.empty()) {
    loads.pins = holds;
  } else {
    held_vertices.set(holds, {end.time - duration, end.absent}, end, duration, mesh, loads.pins);
  }
  if (held_vertices.has_slopes()) set_slopes(end);
  if (!applied_forces.empty()) applied_forces.set(end, mesh, model, loads);
  now = end;
  conditions_changed = false;
}

void Sheet::Impl::set_slopes(const Instant& at) {
  std::vector<fem::Clamp> clamps = held_vertices.clamps(at);
  std::vector<mesh::VertexId> vertices;
  for (const fem::Clamp& clamp : clamps) vertices.push_back(clamp.vertex);
  model.set_clamps(mesh, std::move(clamps));
  // Other vertices make for another matrix; other slopes for other forces only.
  if (vertices == clamped) return;
  clamped = std::move(vertices);
  integrator->rebuild(model);
}

void Sheet::Impl::follow_conditions(std::span<const mesh::MeshEdit* const> edits) {
  if (!held_vertices.empty()) held_vertices.follow(mesh, edits, initial->built);
  if (!applied_forces.empty()) applied_forces.follow(mesh, initial->built);
  conditions_changed = true;
}

fem::EquilibriumStats Sheet::Impl::settle(double load, const fem::EquilibriumOptions& options,
                                          const fem::EquilibriumSolver::Watch& watch) {
  set_conditions({load, load}, 0.0);
  loads.grabs.clear();
  model.bend_by_angles(mesh);
  fem::EquilibriumSolver solver(options);
  solver.rebuild(model);
  mesh::VertexField x = state.x;
  const fem::EquilibriumStats stats = solver.solve(model, loads, watch, x);
  if (!stats.converged) return stats;
  state.x = x;
  state.v.setZero();
  return stats;
}

// A static analysis counts loads as it would ticks.
TickReport Sheet::Impl::begin_load_step() {
  TickReport report;
  const std::int32_t version_before = topology_version;
  drain_commands({}, nullptr, true, report);
  if (conditions_changed) set_conditions(now, 0.0);
  ++tick;
  report.topology_changed = topology_version != version_before;
  stamp(report);
  return report;
}

}  // namespace kerf::sheet
