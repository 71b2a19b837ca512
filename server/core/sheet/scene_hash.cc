#include "server/core/sheet/scene_hash.h"

#include <tuple>
#include <variant>

#include "server/base/fields.h"
#include "server/core/sheet/part_fields.h"

template <>
struct kerf::Fields<kerf::linear::CovarianceRootOptions> {
  static auto of(auto& of) {
    auto& [norm, power, iterations] = of;
    return std::tie(norm, power, iterations);
  }
};
template <>
struct kerf::Fields<kerf::scene::IntegratorSettings> {
  static auto of(auto& of) {
    auto& [kind, substeps, newton, tolerance, solver, linear, root, damping, precision, choice] = of;
    return std::tie(kind, substeps, newton, tolerance, solver, linear, root, damping, precision);
  }
};
template <>
struct kerf::Fields<kerf::scene::History> {
  static auto of(auto& of) {
    auto& [times, factors] = of;
    return std::tie(times, factors);
  }
};
template <>
struct kerf::Fields<kerf::scene::Rotation> {
  static auto of(auto& of) {
    auto& [axis, centre, angle] = of;
    return std::tie(axis, centre, angle);
  }
};
template <>
struct kerf::Fields<kerf::scene::Constraint> {
  static auto of(auto& of) {  // its vertices are those of HeldVertices
    auto& [region, held, displacement, stretch, displacements, rotation, history, until, slope] = of;
    return std::tie(held, displacement, stretch, displacements, rotation, history, until, slope);
  }
};
template <>
struct kerf::Fields<kerf::contact::Plane> {
  static auto of(auto& of) {
    auto& [point, normal] = of;
    return std::tie(point, normal);
  }
};
template <>
struct kerf::Fields<kerf::contact::Sphere> {
  static auto of(auto& of) {
    auto& [centre, radius] = of;
    return std::tie(centre, radius);
  }
};
template <>
struct kerf::Fields<kerf::contact::OrientedBox> {
  static auto of(auto& of) {
    auto& [centre, half_extents, axis, angle] = of;
    return std::tie(centre, half_extents, axis, angle);
  }
};
template <>
struct kerf::Fields<kerf::contact::Capsule> {
  static auto of(auto& of) {
    auto& [a, b, radius] = of;
    return std::tie(a, b, radius);
  }
};

namespace kerf::sheet {

std::uint64_t scene_hash(const InitialState& initial) {
  FieldHasher hasher;
  const auto add = [&](const auto&... values) { (visit(hasher, values), ...); };
  add(initial.built.mesh.state_hash(), initial.built.positions, initial.velocities, initial.pinned, initial.materials,
      initial.held_vertices, initial.applied_forces);
  const scene::SheetConfig& config = *initial.config;
  // Sheets that were saved before there was another choice have a hash without it.
  const scene::IntegratorSettings& integrator = config.integrator;
  const bool is_automatic = integrator.kind == scene::IntegratorKind::kAutomatic;
  if (is_automatic && integrator.choice != scene::kFirstChoice) add(integrator.choice);
  add(config.membrane_law, config.fidelity, config.gravity, config.wind, config.self_contact, config.tick_rate_hz,
      config.integrator, config.max_vertices, config.constraints, config.gravity_history, config.planar,
      config.rest_damping);
  for (const contact::Collider& collider : config.colliders) {
    add(collider.shape.index(), collider.friction);
    std::visit([&](const auto& shape) { add(shape); }, collider.shape);
  }
  for (const scene::Load& load : config.loads) add(load.kind.index(), load.history);
  for (const scene::ScheduledCommand& command : config.commands) add(command.tick, command.command.index());
  return hasher.value();
}

}  // namespace kerf::sheet
