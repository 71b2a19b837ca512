// Reset, and what takes it back.

#include <memory>
#include <utility>

#include "server/core/mesh/mesh_records.h"
#include "server/core/scene/region.h"
#include "server/core/sheet/sheet_impl.h"

namespace kerf::sheet {

std::size_t bytes_of(const Checkpoint& checkpoint) {
  const auto num_vertices = static_cast<std::size_t>(checkpoint.mesh.num_vertices());
  const auto num_slots = static_cast<std::size_t>(checkpoint.mesh.num_triangle_slots());
  const std::size_t per_vertex = sizeof(mesh::PointRecord) + sizeof(mesh::VertexRecord) + 6 * sizeof(double);
  return sizeof(checkpoint) + num_vertices * per_vertex + num_slots * sizeof(mesh::TriangleRecord) +
         checkpoint.holds.size() * (sizeof(fem::Pin) + sizeof(mesh::VertexId));
}

Checkpoint Sheet::Impl::checkpoint() const {
  return {.mesh = mesh,
          .state = state,
          .pinned = pinned,
          .holds = holds,
          .pins_version = pins_version,
          .removed = removed,
          .materials = materials,
          .softening = softening,
          .wind = wind,
          .full_gravity = full_gravity,
          .held_vertices = held_vertices,
          .applied_forces = applied_forces,
          .now = now,
          .scene_tick = tick - start_tick,
          .schedule_place = {schedule_place.start_tick - tick, schedule_place.next},
          .pieces = lineage.pieces(),
          .failed_steps = failed_steps,
          .frozen = frozen,
          .beginning = beginning};
}

Checkpoint Sheet::Impl::initial_checkpoint() const {
  fem::State at_first{initial->built.positions, initial->velocities};
  std::vector<fem::Pin> holds_at_first;
  hold(initial->pinned, at_first, holds_at_first);
  return {.mesh = initial->built.mesh,
          .state = std::move(at_first),
          .pinned = initial->pinned,
          .holds = std::move(holds_at_first),
          .materials = initial->materials,
          .softening = initial->softening,
          .wind = config->wind,
          .full_gravity = config->gravity,
          .held_vertices = initial->held_vertices,
          .applied_forces = initial->applied_forces,
          .now = {},
          .pieces = Lineage(initial->built.mesh.num_pieces()).pieces()};
}

void Sheet::Impl::restore(const Checkpoint& to) {
  mesh = to.mesh;
  state = to.state;
  materials = to.materials;
  softening = to.softening;
  model = make_model(*config, mesh, materials->by_region, softening);
  clamped.clear();  // as in this model; set_slopes() passes new ones to the integrator
  contact.set_half_thickness(0.5 * greatest_thickness(materials->by_region));
  grabs.clear();
  full_gravity = to.full_gravity;
  held_vertices = to.held_vertices;
  applied_forces = to.applied_forces;
  now = to.now;
  start_tick = tick - to.scene_tick;
  schedule_place = {tick + to.schedule_place.start_tick, to.schedule_place.next};
  set_wind(to.wind);
  removed = to.removed;
  pinned = to.pinned;
  holds = to.holds;
  pins_version = to.pins_version;
  conditions_changed = true;
  contact.set_vertices(mesh.num_vertices(), pinned, removed);
  rebuild();
  lineage.restore(to.pieces);
  last_counts.reset();
  failed_steps = to.failed_steps;
  frozen = to.frozen;
  beginning = to.beginning;
  ++topology_version;
  ++settings_version;
  topology.replace();
}

void Sheet::Impl::reset(const Reset& reset) {
  const std::int64_t next = ++last_beginning;
  if (reset.repeats) {
    history.clear();
  } else {
    history.add_reset(std::make_shared<const Checkpoint>(checkpoint()), next);
  }
  restore(initial_checkpoint());
  beginning = next;
}

void Sheet::Impl::redo_reset(const UndoStep& step) {
  const std::int64_t next = step.beginning;
  history.redo_reset(std::make_shared<const Checkpoint>(checkpoint()));
  restore(initial_checkpoint());
  beginning = next;
}

}  // namespace kerf::sheet
