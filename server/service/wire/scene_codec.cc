#include "server/service/wire/scene_codec.h"

#include <array>
#include <string>
#include <utility>
#include <variant>

#include "server/base/overloaded.h"
#include "server/core/scene/sheet_materials.h"
#include "server/service/wire/analysis_codec.h"
#include "server/service/wire/choices.h"
#include "server/service/wire/command_codec.h"
#include "server/service/wire/component_codec.h"
#include "server/service/wire/conditions_codec.h"
#include "server/service/wire/geometry_codec.h"
#include "server/service/wire/integrator_codec.h"
#include "server/service/wire/json.h"
#include "server/service/wire/material_codec.h"
#include "server/service/wire/mesh_source_codec.h"
#include "server/service/wire/region_codec.h"
#include "server/service/wire/self_contact_codec.h"

namespace kerf::wire {
namespace {

Result<contact::Collider> decode_collider(const v1::Collider& message, const std::string& path) {
  contact::Collider collider;
  collider.friction = message.friction();
  switch (message.shape_case()) {
    case v1::Collider::kPlane:
      collider.shape = contact::Plane{decode_vector(message.plane().point()), decode_vector(message.plane().normal())};
      return collider;
    case v1::Collider::kSphere:
      collider.shape = contact::Sphere{decode_vector(message.sphere().center()), message.sphere().radius_m()};
      return collider;
    case v1::Collider::kBox:
      collider.shape =
          contact::OrientedBox{decode_vector(message.box().center()), decode_vector(message.box().half_extents_m()),
                               decode_vector(message.box().axis()), message.box().angle_rad()};
      return collider;
    case v1::Collider::kCapsule:
      collider.shape = contact::Capsule{decode_vector(message.capsule().a()), decode_vector(message.capsule().b()),
                                        message.capsule().radius_m()};
      return collider;
    case v1::Collider::SHAPE_NOT_SET:
      break;
  }
  return choice_missing(path + ".shape", "plane, sphere, box or capsule");
}

constexpr std::array<std::pair<v1::Fidelity, scene::Fidelity>, 2> kFidelities{{
    {v1::EXACT, scene::Fidelity::kExact},
    {v1::REAL_TIME, scene::Fidelity::kRealTime},
}};

Status decode_materials(const v1::Scene& scene, scene::SheetConfig& config) {
  KERF_TRY_ASSIGN(config.material, decode_material(scene.material(), "material"));
  for (int i = 0; i < scene.materials_size(); ++i) {
    KERF_TRY_ASSIGN(scene::RegionMaterial part,
                    decode_part(scene.materials(i), "materials[" + std::to_string(i) + "]"));
    config.materials.push_back(std::move(part));
  }
  KERF_TRY(decode_membrane_law(scene.membrane_law(), config.membrane_law));
  return decode_choice(kFidelities, scene.fidelity(), "fidelity", config.fidelity);
}

// Decodes lists: colliders, scheduled commands.
Status decode_lists(const v1::Scene& scene, const FileReader& read_file, scene::SheetConfig& config) {
  for (int i = 0; i < scene.colliders_size(); ++i) {
    const std::string path = "colliders[" + std::to_string(i) + "]";
    KERF_TRY_ASSIGN(contact::Collider collider, decode_collider(scene.colliders(i), path));
    config.colliders.push_back(std::move(collider));
  }
  for (int i = 0; i < scene.commands_size(); ++i) {
    Result<scene::Command> command = decode_command(scene.commands(i).command(), read_file);
    if (!command.ok()) return within("commands[" + std::to_string(i) + "].command", command.error());
    config.commands.push_back({scene.commands(i).tick(), std::move(*command)});
  }
  return Nothing{};
}

}  // namespace

Result<scene::SheetConfig> decode_scene(v1::Scene scene, const FileReader& read_file) {
  scene::SheetConfig config;
  config.sheet_id = scene.sheet_id();
  if (scene.components().empty()) {
    KERF_TRY_ASSIGN(config.mesh, decode_mesh_source(scene, read_file));
    config.placement = decode_placement(scene.placement());
  } else {
    KERF_TRY(decode_components(scene, read_file, config));
  }
  KERF_TRY(decode_materials(scene, config));
  KERF_TRY_ASSIGN(config.pins, decode_pins(scene.pins(), "pins"));
  if (scene.has_gravity_mps2()) config.gravity = decode_vector(scene.gravity_mps2());
  if (scene.has_wind()) config.wind = decode_wind(scene.wind());
  if (scene.has_tick_rate_hz()) config.tick_rate_hz = scene.tick_rate_hz();
  KERF_TRY(decode_integrator(scene.integrator(), config.integrator));
  KERF_TRY_ASSIGN(config.self_contact, decode_self_contact(scene.self_contact()));
  KERF_TRY(decode_lists(scene, read_file, config));
  KERF_TRY(decode_conditions(scene, config));
  KERF_TRY(decode_analysis(scene, config));
  if (scene.max_vertices() != 0) config.max_vertices = scene.max_vertices();
  config.ticks = scene.ticks();
  config.repeat_after = scene.repeat_after_ticks();
  if (scene.has_rest_damping()) config.rest_damping = scene.rest_damping();
  config.description = scene.description();
  KERF_TRY(scene::validate(config));
  return config;
}

v1::Collider encode_collider(const contact::Collider& collider) {
  v1::Collider message;
  message.set_friction(collider.friction);
  std::visit(Overloaded{
                 [&message](const contact::Plane& plane) {
                   encode_vector(plane.point, *message.mutable_plane()->mutable_point());
                   encode_vector(plane.normal, *message.mutable_plane()->mutable_normal());
                 },
                 [&message](const contact::Sphere& sphere) {
                   encode_vector(sphere.centre, *message.mutable_sphere()->mutable_center());
                   message.mutable_sphere()->set_radius_m(sphere.radius);
                 },
                 [&message](const contact::OrientedBox& box) {
                   encode_vector(box.centre, *message.mutable_box()->mutable_center());
                   encode_vector(box.half_extents, *message.mutable_box()->mutable_half_extents_m());
                   encode_vector(box.axis, *message.mutable_box()->mutable_axis());
                   message.mutable_box()->set_angle_rad(box.angle);
                 },
                 [&message](const contact::Capsule& capsule) {
                   encode_vector(capsule.a, *message.mutable_capsule()->mutable_a());
                   encode_vector(capsule.b, *message.mutable_capsule()->mutable_b());
                   message.mutable_capsule()->set_radius_m(capsule.radius);
                 },
             },
             collider.shape);
  return message;
}

v1::Scene encode_settings(const SettingsInForce& settings) {
  v1::Scene scene;
  *scene.mutable_material() = encode_material(settings.materials.front());
  for (std::size_t i = 0; i < settings.config.materials.size(); ++i) {
    v1::RegionMaterial& message = *scene.add_materials();
    encode_region(settings.config.materials[i].region, *message.mutable_region());
    *message.mutable_material() = encode_material(settings.materials[i + 1]);
  }
  scene.set_membrane_law(encode_membrane_law(settings.config.membrane_law));
  scene.set_fidelity(encode_choice(kFidelities, settings.config.fidelity));
  encode_vector(settings.gravity, *scene.mutable_gravity_mps2());
  if (settings.wind.air_density > 0.0) encode_wind(settings.wind, *scene.mutable_wind());
  for (const contact::Collider& collider : settings.config.colliders) {
    *scene.add_colliders() = encode_collider(collider);
  }
  if (settings.self_contact != scene::SelfContact{}) {
    *scene.mutable_self_contact() = encode_self_contact(settings.self_contact);
  }
  if (settings.config.components.empty()) encode_placement(settings.config.placement, *scene.mutable_placement());
  scene.set_sheet_id(settings.config.sheet_id);
  scene.set_tick_rate_hz(settings.config.tick_rate_hz);
  *scene.mutable_integrator() = encode_integrator(settings.config.integrator);
  scene.set_max_vertices(settings.config.max_vertices);
  scene.set_ticks(settings.config.ticks);
  scene.set_repeat_after_ticks(settings.config.repeat_after);
  if (!settings.config.rest_damping) scene.set_rest_damping(false);
  scene.set_description(settings.config.description);
  return scene;
}

v1::Scene encode_scene(const scene::SheetConfig& config) {
  v1::Scene scene =
      encode_settings({config, scene::materials_of(config), config.gravity, config.wind, config.self_contact});
  if (config.components.empty()) encode_mesh_source(config.mesh, scene);
  for (const scene::Component& component : config.components) *scene.add_components() = encode_component(component);
  encode_pins(config.pins, *scene.mutable_pins());
  encode_conditions(config, scene);
  encode_analysis(config, scene);
  for (const scene::ScheduledCommand& scheduled : config.commands) {
    v1::ScheduledCommand& message = *scene.add_commands();
    message.set_tick(scheduled.tick);
    *message.mutable_command() = encode_command(scheduled.command);
  }
  return scene;
}

Result<scene::SheetConfig> decode_scene_file(std::string_view json, const FileReader& read_file) {
  v1::Scene scene;
  KERF_TRY(from_json(json, scene));
  return decode_scene(std::move(scene), read_file);
}

}  // namespace kerf::wire
