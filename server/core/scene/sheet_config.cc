#include "server/core/scene/sheet_config.h"

#include <algorithm>
#include <cmath>

#include "server/core/mesh/build/mesh_import.h"
#include "server/core/scene/components.h"
#include "server/core/scene/field_checks.h"
#include "server/core/scene/integrator_settings.h"
#include "server/core/scene/outline_source.h"
#include "server/core/scene/sheet_materials.h"

namespace kerf::scene {

namespace {

constexpr std::int32_t kMaxGridSide = 1000;  // most vertices along x, and along y
constexpr double kMinExtent = 1.0e-6;        // m, least side of a grid
constexpr double kAxisTolerance = 1.0e-6;    // -; tolerance of the length of the placement's axes, and of the cosine
                                             // between them
constexpr double kMinUnit = 1e-9;            // m, of a mesh file
constexpr double kMaxUnit = 1e6;             // m
constexpr std::size_t kMaxDescriptionBytes = 1000;
constexpr std::int64_t kMaxTicks = 10'000'000;

Status validate_source(const GridSource& grid) {
  KERF_TRY(check_integer(grid.columns, 2, kMaxGridSide, "grid.columns"));
  KERF_TRY(check_integer(grid.rows, 2, kMaxGridSide, "grid.rows"));
  const std::int64_t num_vertices = std::int64_t{grid.columns} * grid.rows;
  if (num_vertices > kMaxVertices) {
    return invalid_argument(
        "TOO_MANY",
        "grid has " + std::to_string(num_vertices) + " vertices; the limit is " + std::to_string(kMaxVertices),
        "grid.rows");
  }
  KERF_TRY(check_number(grid.width, kMinExtent, kMaxMaterialCoordinate, "grid.width_m"));
  return check_number(grid.height, kMinExtent, kMaxMaterialCoordinate, "grid.height_m");
}

Status validate_reading(const mesh::MeshReading& reading, const std::string& field) {
  KERF_TRY(check_number(reading.unit_m, kMinUnit, kMaxUnit, field + ".unit_m"));
  if (reading.join_m) KERF_TRY(check_number(*reading.join_m, 0.0, mesh::kMaxRestCoordinate, field + ".join_m"));
  KERF_TRY(check_count(reading.objects.size(), kMaxReadObjects, "names", field + ".objects"));
  return check_integer(reading.version, mesh::kFirstReader, mesh::kNewestReader, field + ".reader_version");
}

Status validate_source(const ObjSource& obj) {
  if (obj.text.empty()) return invalid_argument("EMPTY", "obj.text must not be empty", "obj.text");
  KERF_TRY(validate_reading(obj.reading, "obj.reading"));
  return check_count(obj.text.size(), kMaxMeshFileBytes, "bytes", "obj.text");
}

Status validate_source(const PlySource& ply) {
  if (ply.data.empty()) return invalid_argument("EMPTY", "ply.data must not be empty", "ply.data");
  KERF_TRY(validate_reading(ply.reading, "ply.reading"));
  return check_count(ply.data.size(), kMaxMeshFileBytes, "bytes", "ply.data");
}

Status validate_source(const ArraySource& arrays) {
  const Eigen::Index num_vertices = arrays.num_vertices();
  const bool is_curved = arrays.rest_positions.cols() > 0;
  const std::string field = is_curved ? "inline.rest_positions" : "inline.material_positions";
  KERF_TRY(check_integer(num_vertices, 3, kMaxVertices, field));
  if (const Eigen::Index given = arrays.material_positions.cols(); given != num_vertices && given != 0) {
    return invalid_argument("LENGTH_MISMATCH",
                            "inline.material_positions has " + std::to_string(given) + " points; must have none or " +
                                std::to_string(num_vertices) + ", as many as rest_positions",
                            "inline.material_positions");
  }
  if (arrays.triangles.cols() == 0) {
    return invalid_argument("EMPTY", "inline.triangles must not be empty", "inline.triangles");
  }
  KERF_TRY(check_integer(arrays.triangles.cols(), 1, 2 * std::int64_t{kMaxVertices}, "inline.triangles"));
  const Eigen::Index num_positions = arrays.positions.cols();
  if (num_positions != 0 && num_positions != num_vertices) {
    return invalid_argument("LENGTH_MISMATCH",
                            "inline.positions has " + std::to_string(num_positions) + " points; must have none or " +
                                std::to_string(num_vertices) + ", as many as the sheet has vertices",
                            "inline.positions");
  }
  for (Eigen::Index i = 0; i < num_positions; ++i) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double value = arrays.positions(k, i);
      if (std::abs(value) <= kMaxWorldCoordinate) continue;  // false for NaN
      return check_number(value, -kMaxWorldCoordinate, kMaxWorldCoordinate,
                          indexed("inline.positions", static_cast<std::size_t>(3 * i + k)));
    }
  }
  return Nothing{};
}

Status validate_source(const OutlineSource& outline) {
  return validate(outline);
}

Status check_unit(const Eigen::Vector3d& axis, const std::string& field) {
  KERF_TRY(check_vector(axis, kMaxWorldCoordinate, field));
  if (std::abs(axis.norm() - 1.0) <= kAxisTolerance) return Nothing{};
  return invalid_argument(
      "NOT_UNIT", field + " has length " + std::to_string(axis.norm()) + "; must have length 1 (to 1e-6)", field);
}

Status validate_source(const MeshSource& source) {
  return std::visit([](const auto& each) { return validate_source(each); }, source);
}

}  // namespace

Status validate(const MeshSource& source) {
  return validate_source(source);
}

namespace {

Status validate_placement(const Placement& placement) {
  KERF_TRY(check_vector(placement.origin, kMaxWorldCoordinate, "placement.origin"));
  KERF_TRY(check_unit(placement.x_axis, "placement.x_axis"));
  KERF_TRY(check_unit(placement.y_axis, "placement.y_axis"));
  if (std::abs(placement.x_axis.dot(placement.y_axis)) <= kAxisTolerance) return Nothing{};
  return invalid_argument("NOT_PERPENDICULAR", "placement.y_axis must be perpendicular to x_axis (to 1e-6)",
                          "placement.y_axis");
}

Status validate_component(const SheetConfig& config, std::size_t index) {
  const Component& component = config.components[index];
  if (!is_valid_sheet_id(component.name)) {
    return invalid_argument("COMPONENT_NAME", "name must match [a-z][a-z0-9-]{0,62}", "name");
  }
  const auto end = config.components.begin() + static_cast<std::ptrdiff_t>(index);
  if (std::any_of(config.components.begin(), end, [&](const Component& each) { return each.name == component.name; })) {
    return invalid_argument("COMPONENT_NAME", "another component has this name; each needs its own", "name");
  }
  KERF_TRY(validate_source(component.mesh));
  if (component.placement) KERF_TRY(validate_placement(*component.placement));
  return check_vector(component.offset.value_or(Eigen::Vector2d::Zero()), kMaxMaterialCoordinate, "offset");
}

// Checks the mesh and its placement, or the components.
Status validate_shape(const SheetConfig& config) {
  if (config.components.empty()) {
    KERF_TRY(validate_source(config.mesh));
    return validate_placement(config.placement);
  }
  KERF_TRY(check_count(config.components.size(), kMaxComponents, "components", "components"));
  for (std::size_t i = 0; i < config.components.size(); ++i) {
    if (const Status valid = validate_component(config, i); !valid.ok()) {
      return in_component(valid.error(), i, config.components[i].name);
    }
  }
  return Nothing{};
}

// Checks that the scene has the components that a command names.
Status validate_names(const SheetConfig& config, const Command& command) {
  const auto check = [&](const std::string& name, const std::string& field) -> Status {
    std::vector<std::string> names;
    for (const Component& component : config.components) names.push_back(component.name);
    if (name.empty() || std::find(names.begin(), names.end(), name) != names.end()) return Nothing{};
    return unknown_component(name, names, field);
  };
  if (const auto* cut = std::get_if<Cut>(&command)) return check(cut->component, "cut.component");
  if (const auto* batch = std::get_if<CutBatch>(&command)) {
    for (std::size_t i = 0; i < batch->cuts.size(); ++i) {
      if (const Status known = check(batch->cuts[i].component, "cut.component"); !known.ok()) {
        return in_batch(known.error(), i);
      }
    }
  }
  if (const auto* pins = std::get_if<SetPins>(&command)) {
    for (std::size_t i = 0; i < pins->pins.size(); ++i) {
      KERF_TRY(check(pins->pins[i].component, indexed("set_pins.pins", i) + ".component"));
    }
  }
  return Nothing{};
}

Status validate_self_contact(const SheetConfig& config) {
  const SelfContact& given = config.self_contact;
  KERF_TRY(validate(SetSelfContact{given.is_on, given.friction, given.thickness}, "self_contact"));
  if (!given.is_on) return Nothing{};
  if (config.planar) {
    return invalid_argument("SELF_CONTACT_PLANAR",
                            "self_contact.mode is ON, but a planar sheet has no folds that could touch: set "
                            "self_contact.mode to OFF, or planar to false",
                            "self_contact.mode");
  }
  return Nothing{};
}

Status validate_schedule(const SheetConfig& config) {
  const std::vector<ScheduledCommand>& commands = config.commands;
  KERF_TRY(check_count(commands.size(), kMaxScheduledCommands, "commands", "commands"));
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const std::string field = indexed("commands", i);
    if (commands[i].tick < 1) {
      return invalid_argument("OUT_OF_RANGE",
                              field + ".tick is " + std::to_string(commands[i].tick) + "; the first tick is 1",
                              field + ".tick");
    }
    if (const auto* reset = std::get_if<Reset>(&commands[i].command); reset != nullptr && reset->repeats) {
      return invalid_argument(
          "OUT_OF_RANGE", field + ".command.reset.repeats is for recordings only; set repeat_after_ticks of the scene",
          field + ".command.reset.repeats");
    }
    Status valid = validate(commands[i].command);
    if (valid.ok()) valid = validate_names(config, commands[i].command);
    if (!valid.ok()) {
      Error error = valid.error();
      error.field = field + ".command." + error.field;
      return error;
    }
  }
  return Nothing{};
}

}  // namespace

bool schedules_cuts(const SheetConfig& config) {
  return std::any_of(config.commands.begin(), config.commands.end(), [](const ScheduledCommand& scheduled) {
    return std::holds_alternative<Cut>(scheduled.command) || std::holds_alternative<CutBatch>(scheduled.command);
  });
}

bool is_valid_sheet_id(std::string_view id) {
  if (id.empty() || id.size() > kMaxSheetIdBytes || id[0] < 'a' || id[0] > 'z') return false;
  for (const char c : id) {
    const bool allowed = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
    if (!allowed) return false;
  }
  return true;
}

Status validate(const SheetConfig& config) {
  if (!config.sheet_id.empty() && !is_valid_sheet_id(config.sheet_id)) {
    return invalid_argument("SHEET_ID", "sheet_id must match [a-z][a-z0-9-]{0,62}", "sheet_id");
  }
  KERF_TRY(validate_shape(config));
  KERF_TRY(fem::validate(config.material));
  KERF_TRY(validate(config.materials, config.material));
  KERF_TRY(validate(config.pins, "pins"));
  KERF_TRY(check_length(config.gravity, kMaxGravity, "gravity_mps2"));
  KERF_TRY(validate(config.wind, "wind"));
  KERF_TRY(check_count(config.colliders.size(), kMaxColliders, "colliders", "colliders"));
  for (std::size_t i = 0; i < config.colliders.size(); ++i) {
    KERF_TRY(contact::validate(config.colliders[i], indexed("colliders", i)));
  }
  KERF_TRY(validate(config.constraints));
  KERF_TRY(validate(config.loads));
  KERF_TRY(validate(config.gravity_history, "gravity_history"));
  if (config.initial_velocity) {
    KERF_TRY(validate(*config.initial_velocity));
  }
  KERF_TRY(validate(config.analysis));
  KERF_TRY(validate(config.probes));
  KERF_TRY(check_number(config.tick_rate_hz, 1.0, 1000.0, "tick_rate_hz"));
  KERF_TRY(validate(config.integrator));
  KERF_TRY(validate_self_contact(config));
  KERF_TRY(check_integer(config.max_vertices, 3, kMaxVertices, "max_vertices"));
  KERF_TRY(validate_schedule(config));
  KERF_TRY(check_integer(config.ticks, 0, kMaxTicks, "ticks"));
  KERF_TRY(check_integer(config.repeat_after, 0, kMaxTicks, "repeat_after_ticks"));
  return check_count(config.description.size(), kMaxDescriptionBytes, "bytes", "description");
}

}  // namespace kerf::scene
