// Reset, its undo and its redo.

#include <memory>
#include <utility>

#include "server/core/mesh/mesh_data.h"
#include "server/core/sheet/sheet_impl.h"

namespace kerf::sheet {

std::size_t bytes_of(const Checkpoint& checkpoint) {
  const MovingState& moving = checkpoint.moving;
  const auto num_vertices = static_cast<std::size_t>(moving.mesh.num_vertices());
  const auto num_slots = static_cast<std::size_t>(moving.mesh.num_triangle_slots());
  const std::size_t per_vertex = sizeof(mesh::PointRecord) + sizeof(mesh::VertexRecord) + 6 * sizeof(double);
  return sizeof(checkpoint) + num_vertices * per_vertex + num_slots * sizeof(mesh::TriangleRecord) +
         moving.pins.holds().size() * (sizeof(fem::Pin) + sizeof(mesh::VertexId));
}

std::shared_ptr<const Checkpoint> Sheet::Impl::checkpoint() const {
  return std::make_shared<const Checkpoint>(Checkpoint{moving.save(), clock.save(), cuts.pieces(), beginning});
}

void Sheet::Impl::restore(const Checkpoint& to) {
  moving.restore(to.moving);
  clock.restore(to.place);
  cuts.restore_pieces(to.pieces);
  beginning = to.beginning;
  ++topology_version;
  ++settings_version;
  topology.replace();
}

void Sheet::Impl::reset(const scene::Reset& reset) {
  const std::int64_t number = ++last_beginning;
  if (reset.repeats) {
    cuts.history().clear();
  } else {
    cuts.history().add_reset(checkpoint(), number);
  }
  restart(number);
}

void Sheet::Impl::redo_reset(const UndoStep& step) {
  const std::int64_t number = step.beginning;
  cuts.history().redo_reset(checkpoint());
  restart(number);
}

// Begins the scene again. `number`: see CommandReply::beginning.
void Sheet::Impl::restart(std::int64_t number) {
  const std::int32_t num_pieces = moving.initial().built.mesh.num_pieces();
  restore({moving.initial_state(), {}, scene::Lineage(num_pieces).pieces(), number});
}

}  // namespace kerf::sheet
