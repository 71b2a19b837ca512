#include "server/sheet/contact_bridge.h"

namespace kerf::sheet {

void ContactBridge::set_colliders(std::span<const contact::Collider> colliders, double half_thickness) {
  solver_.set_colliders(colliders);
  half_thickness_ = half_thickness;
}

void ContactBridge::set_vertices(std::int32_t num_vertices, const std::vector<mesh::VertexId>& pinned) {
  is_pinned_.assign(static_cast<std::size_t>(num_vertices), 0);
  for (const mesh::VertexId v : pinned) is_pinned_[static_cast<std::size_t>(v)] = 1;
  x_before_.resize(3, num_vertices);
}

void ContactBridge::enforce(double /*dt*/, fem::State& state) {
  solver_.resolve(half_thickness_, is_pinned_, x_before_, state.x, state.v);
  x_before_ = state.x;
}

}  // namespace kerf::sheet
