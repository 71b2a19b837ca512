#include "server/core/scene/command.h"

#include <string_view>

#include "server/base/overloaded.h"
#include "server/core/cut/cut_types.h"
#include "server/core/scene/field_checks.h"

namespace kerf::scene {

namespace {

// degrees, least CutOptions::min_angle_deg of a Cut; 0 would leave slivers, which shorten every step
constexpr double kMinCutAngle = 5.0;

Status check_grab_id(const std::string& grab_id, const std::string& field) {
  if (grab_id.empty()) return invalid_argument("EMPTY", field + " must not be empty", field);
  return check_count(grab_id.size(), kMaxGrabIdBytes, "bytes", field);
}

Status validate_command(const Cut& cut) {
  const cut::CutOptions& options = cut.options;
  KERF_TRY(cut::validate(cut.curve));
  KERF_TRY(cut::check_ranges(options, kMinCutAngle,
                             Overloaded{
                                 [](double value, double low, double high, const char* field) {
                                   return check_number(value, low, high, field);
                                 },
                                 [](std::int32_t value, std::int32_t low, std::int32_t high, const char* field) {
                                   return check_integer(value, low, high, field);
                                 },
                             }));
  if (options.method == cut::Method::kElement && (options.tip_edge_length_m || options.width_m)) {
    const std::string field = options.width_m ? "cut.width_m" : "cut.tip_edge_length_m";
    return invalid_argument("OPTIONS_CONFLICT", field + " needs method NEIGHBOURHOOD; leave one of them out", field);
  }
  if (!cut.view) return Nothing{};
  if (!cut.component.empty()) {
    return invalid_argument(
        "COMPONENT_WITH_VIEW",
        "a curve in pixels of a picture cannot be in the coordinates of a component, too: leave out "
        "the component or the view",
        "cut.component");
  }
  if (options.fit) {
    return invalid_argument("FIT_WITH_VIEW",
                            "a curve in pixels of a picture cannot be fitted into a box of the sheet, as a drawing "
                            "always is: leave out the view, or give pixels",
                            "cut.fit");
  }
  return cut::validate(*cut.view);
}

Status validate_command(const CutBatch& batch) {
  if (batch.cuts.empty()) {
    return invalid_argument("EMPTY", "cut_batch.cuts must hold at least one cut", "cut_batch.cuts");
  }
  KERF_TRY(check_count(batch.cuts.size(), kMaxBatchCuts, "cuts", "cut_batch.cuts"));
  for (std::size_t i = 0; i < batch.cuts.size(); ++i) {
    if (Status s = validate_command(batch.cuts[i]); !s.ok()) return in_batch(s.error(), i);
  }
  return Nothing{};
}

Status validate_command(const UndoCut& /*undo*/) {
  return Nothing{};
}

Status validate_command(const RedoCut& /*redo*/) {
  return Nothing{};
}

Status validate_command(const Grab& grab) {
  KERF_TRY(check_grab_id(grab.grab_id, "grab.grab_id"));
  if (const auto* vertex = std::get_if<mesh::VertexId>(&grab.point)) {
    KERF_TRY(check_vertex_id(*vertex, "grab.vertex"));
  } else {
    KERF_TRY(check_vector(std::get<Eigen::Vector2d>(grab.point), kMaxMaterialCoordinate, "grab.material"));
  }
  if (grab.target) {
    KERF_TRY(check_vector(*grab.target, kMaxWorldCoordinate, "grab.target"));
  }
  return check_number(grab.stiffness, 0.0, kMaxGrabStiffness, "grab.stiffness_npm");
}

Status validate_command(const Drag& drag) {
  KERF_TRY(check_grab_id(drag.grab_id, "drag.grab_id"));
  return check_vector(drag.target, kMaxWorldCoordinate, "drag.target");
}

Status validate_command(const Release& release) {
  return check_grab_id(release.grab_id, "release.grab_id");
}

Status validate_command(const SetPins& set_pins) {
  return validate(set_pins.pins, "set_pins.pins");
}

Status validate_command(const SetGravity& set_gravity) {
  return check_length(set_gravity.gravity, kMaxGravity, "set_gravity.gravity_mps2");
}

Status validate_command(const SetWind& set_wind) {
  return validate(set_wind.wind, "set_wind.wind");
}

Status validate_command(const SetMaterial& set_material) {
  KERF_TRY(fem::validate(set_material.material, "set_material.material"));
  const std::int32_t part = set_material.part.value_or(SetMaterial::kOwn);
  return check_integer(part, SetMaterial::kOwn, static_cast<std::int32_t>(kMaxRegions) - 1, "set_material.part");
}

Status validate_command(const SetSelfContact& set_self_contact) {
  return validate(set_self_contact, "set_self_contact");
}

Status validate_command(const Reset& /*reset*/) {
  return Nothing{};
}

}  // namespace

Error in_batch(Error error, std::size_t index) {
  constexpr std::string_view kCut = "cut";
  const std::string path = "cut_batch.cuts[" + std::to_string(index) + "]";
  const bool is_path = error.field.starts_with(kCut);
  error.field = is_path ? path + error.field.substr(kCut.size()) : path;
  error.message = "cut " + std::to_string(index) + " of the batch: " + error.message;
  return error;
}

Status validate(const Wind& wind, const std::string& field) {
  KERF_TRY(check_length(wind.velocity, kMaxWindSpeed, field + ".velocity_mps"));
  KERF_TRY(check_number(wind.air_density, 0.0, kMaxAirDensity, field + ".air_density_kgpm3"));
  return check_number(wind.drag_coefficient, 0.0, kMaxDragCoefficient, field + ".drag_coefficient");
}

Status validate(const SetSelfContact& settings, const std::string& path) {
  if (settings.friction) {
    KERF_TRY(check_number(*settings.friction, 0.0, kMaxSelfFriction, path + ".friction"));
  }
  if (settings.thickness) {
    KERF_TRY(check_number(*settings.thickness, kMinSelfThickness, kMaxSelfThickness, path + ".thickness_m"));
  }
  if (settings.thickness && settings.material_thickness) {
    return invalid_argument("CHOICE_AMBIGUOUS", "thickness_m and material_thickness are both given; give one of them",
                            path + ".material_thickness");
  }
  return Nothing{};
}

SelfContact with(SelfContact settings, const SetSelfContact& change) {
  if (change.is_on) settings.is_on = *change.is_on;
  if (change.friction) settings.friction = *change.friction;
  if (change.thickness || change.material_thickness) settings.thickness = change.thickness;
  return settings;
}

Status validate(const Command& command) {
  return std::visit([](const auto& c) { return validate_command(c); }, command);
}

}  // namespace kerf::scene
