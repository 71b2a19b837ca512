#include "server/service/wire/command_codec.h"

#include <iterator>
#include <string>
#include <utility>
#include <variant>

#include "server/service/wire/geometry_codec.h"
#include "server/service/wire/material_codec.h"
#include "server/service/wire/region_codec.h"
#include "server/service/wire/self_contact_codec.h"
#include "server/service/wire/view_codec.h"

namespace kerf::wire {
namespace {

Result<scene::Command> checked(scene::Command command) {
  KERF_TRY(scene::validate(command));
  return command;
}

void encode(const scene::Cut& cut, v1::Command& message) {
  *message.mutable_cut() = encode_cut(cut);
}

void encode(const scene::CutBatch& batch, v1::Command& message) {
  for (const scene::Cut& cut : batch.cuts) *message.mutable_cut_batch()->add_cuts() = encode_cut(cut);
}

void encode(const scene::UndoCut& /*undo*/, v1::Command& message) {
  message.mutable_undo_cut();
}

void encode(const scene::RedoCut& /*redo*/, v1::Command& message) {
  message.mutable_redo_cut();
}

Status decode_method(const v1::Cut& message, cut::CutOptions& options) {
  switch (message.method()) {
    case v1::Cut::METHOD_UNSPECIFIED:
    case v1::Cut::NEIGHBOURHOOD:
      return Nothing{};
    case v1::Cut::ELEMENT:
      options.method = cut::Method::kElement;
      return Nothing{};
    default:
      return unknown_enum("cut.method", message.method());
  }
}

// Decodes a quality, which names a lower bound on the angles of new triangles.
Status decode_quality(const v1::Cut& message, cut::CutOptions& options) {
  switch (message.quality()) {
    case v1::Cut::QUALITY_UNSPECIFIED:
    case v1::Cut::DEFAULT:
      return Nothing{};
    case v1::Cut::FINE:
      if (message.min_angle_deg() != 0.0) {
        return invalid_argument("CHOICE_AMBIGUOUS",
                                "cut.quality FINE and cut.min_angle_deg both set the smallest angle; give one of them",
                                "cut.quality");
      }
      options.min_angle_deg = cut::kFineMinAngle;
      return Nothing{};
    default:
      return unknown_enum("cut.quality", message.quality());
  }
}

void encode(const scene::Grab& grab, v1::Command& message) {
  v1::Grab& grab_message = *message.mutable_grab();
  grab_message.set_grab_id(grab.grab_id);
  if (const auto* vertex = std::get_if<mesh::VertexId>(&grab.point)) {
    grab_message.set_vertex(*vertex);
  } else {
    encode_vector(std::get<Eigen::Vector2d>(grab.point), *grab_message.mutable_material());
  }
  if (grab.target) encode_vector(*grab.target, *grab_message.mutable_target());
  grab_message.set_stiffness_npm(grab.stiffness);
}

void encode(const scene::Drag& drag, v1::Command& message) {
  message.mutable_drag()->set_grab_id(drag.grab_id);
  encode_vector(drag.target, *message.mutable_drag()->mutable_target());
}

void encode(const scene::Release& release, v1::Command& message) {
  message.mutable_release()->set_grab_id(release.grab_id);
}

void encode(const scene::SetPins& set_pins, v1::Command& message) {
  encode_pins(set_pins.pins, *message.mutable_set_pins()->mutable_pins());
}

void encode(const scene::SetGravity& set_gravity, v1::Command& message) {
  encode_vector(set_gravity.gravity, *message.mutable_set_gravity()->mutable_gravity_mps2());
}

void encode(const scene::SetWind& set_wind, v1::Command& message) {
  v1::SetWind& wind_message = *message.mutable_set_wind();
  if (set_wind.wind.air_density > 0.0) encode_wind(set_wind.wind, *wind_message.mutable_wind());
}

void encode(const scene::SetMaterial& set_material, v1::Command& message) {
  *message.mutable_set_material()->mutable_material() = encode_material(set_material.material);
  if (set_material.part) message.mutable_set_material()->set_part(*set_material.part);
}

void encode(const scene::SetSelfContact& set_self_contact, v1::Command& message) {
  *message.mutable_set_self_contact() = encode_self_contact_change(set_self_contact);
}

void encode(const scene::Reset& reset, v1::Command& message) {
  message.mutable_reset()->set_repeats(reset.repeats);
}

Result<cut::Fit> decode_fit(const v1::MaterialBox& message) {
  if (!message.has_min() && !message.has_max()) return cut::Fit{};
  if (!message.has_min()) return missing("cut.fit.min");
  if (!message.has_max()) return missing("cut.fit.max");
  return cut::Fit{cut::Box{decode_vector(message.min()), decode_vector(message.max())}};
}

// Decodes a cut without validating it.
Result<scene::Cut> read_cut(const v1::Cut& message, const FileReader& read_file) {
  // Dashes of the cut replace those of a drawing.
  KERF_TRY_ASSIGN(DecodedCurve decoded, decode_curve(message.curve(), "cut.curve", read_file, message.dash().empty()));
  scene::Cut cut;
  cut.curve = std::move(decoded.curve);
  cut.remarks = std::move(decoded.remarks);
  cut.component = message.component();
  cut::CutOptions& options = cut.options;
  if (message.tolerance() != 0.0) options.tolerance = message.tolerance();
  if (message.min_angle_deg() != 0.0) options.min_angle_deg = message.min_angle_deg();
  if (message.max_new_triangles() != 0) options.max_new_triangles = message.max_new_triangles();
  if (message.has_fit() && decoded.is_placed) {
    return invalid_argument("OPTIONS_CONFLICT", "cut.fit and true_size both place the drawing; leave one of them out",
                            "cut.fit");
  }
  if (message.has_fit()) {
    KERF_TRY_ASSIGN(options.fit, decode_fit(message.fit()));
  } else if (decoded.is_drawing && !decoded.is_placed) {
    options.fit = cut::Fit{};
  }
  options.dash = {{message.dash().begin(), message.dash().end()}, message.dash_offset()};
  if (message.has_view()) {
    KERF_TRY_ASSIGN(cut.view, decode_view(message.view(), "cut.view"));
  }
  KERF_TRY(decode_method(message, options));
  KERF_TRY(decode_quality(message, options));
  if (message.tolerance_m() != 0.0) options.tolerance_m = message.tolerance_m();
  if (message.tip_edge_length_m() != 0.0) options.tip_edge_length_m = message.tip_edge_length_m();
  if (message.tip_grading() != 0.0) options.tip_grading = message.tip_grading();
  if (message.has_relax()) options.relax = message.relax();
  if (message.width_m() != 0.0) options.width_m = message.width_m();
  if (message.join_m() != 0.0) options.join_m = message.join_m();
  return cut;
}

}  // namespace

v1::Cut encode_cut(const scene::Cut& cut) {
  const cut::CutOptions& options = cut.options;
  v1::Cut message;
  encode_curve(cut.curve, *message.mutable_curve());
  message.set_tolerance(options.tolerance);
  message.set_min_angle_deg(options.min_angle_deg);
  message.set_max_new_triangles(options.max_new_triangles);
  if (options.tolerance_m) message.set_tolerance_m(*options.tolerance_m);
  message.set_method(options.method == cut::Method::kElement ? v1::Cut::ELEMENT : v1::Cut::NEIGHBOURHOOD);
  if (options.tip_edge_length_m) message.set_tip_edge_length_m(*options.tip_edge_length_m);
  message.set_tip_grading(options.tip_grading);
  message.set_relax(options.relax);
  if (options.width_m) message.set_width_m(*options.width_m);
  if (options.join_m) message.set_join_m(*options.join_m);
  if (options.fit) {
    v1::MaterialBox& box = *message.mutable_fit();
    if (options.fit->box) {
      encode_vector(options.fit->box->low, *box.mutable_min());
      encode_vector(options.fit->box->high, *box.mutable_max());
    }
  }
  message.mutable_dash()->Add(options.dash.lengths.begin(), options.dash.lengths.end());
  message.set_dash_offset(options.dash.offset);
  if (cut.view) encode_view(*cut.view, *message.mutable_view());
  message.set_component(cut.component);
  return message;
}

std::int64_t num_parts(const scene::Cut& cut) {
  std::int64_t parts = 1;
  if (const auto* path = std::get_if<cut::Path>(&cut.curve)) {
    for (const cut::Subpath& subpath : path->subpaths) parts += 1 + std::ssize(subpath.segments);
  }
  return parts;
}

Result<scene::Command> decode_cuts(const google::protobuf::RepeatedPtrField<v1::Cut>& cuts,
                                   const FileReader& read_file) {
  scene::CutBatch batch;
  std::int64_t parts = 0;
  for (int i = 0; i < cuts.size(); ++i) {
    Result<scene::Cut> cut = read_cut(cuts[i], read_file);
    if (!cut.ok()) return scene::in_batch(cut.error(), static_cast<std::size_t>(i));
    batch.cuts.push_back(std::move(*cut));
    parts += num_parts(batch.cuts.back());
    if (parts > kMaxBatchParts) {
      return scene::in_batch(invalid_argument("BATCH_TOO_LONG",
                                              "with this cut, the cuts, subpaths and segments of the batch exceed " +
                                                  std::to_string(kMaxBatchParts) + ": split the batch",
                                              "cut.curve"),
                             static_cast<std::size_t>(i));
    }
  }
  return checked(std::move(batch));
}

Result<scene::Command> decode_cut(const v1::Cut& message, const FileReader& read_file) {
  KERF_TRY_ASSIGN(scene::Cut cut, read_cut(message, read_file));
  return checked(std::move(cut));
}

Result<scene::Command> decode_grab(const v1::Grab& message) {
  scene::Grab grab;
  grab.grab_id = message.grab_id();
  switch (message.point_case()) {
    case v1::Grab::kVertex:
      grab.point = message.vertex();
      break;
    case v1::Grab::kMaterial:
      grab.point = decode_vector(message.material());
      break;
    case v1::Grab::POINT_NOT_SET:
      return choice_missing("grab.point", "vertex or material");
  }
  if (message.has_target()) grab.target = decode_vector(message.target());
  grab.stiffness = message.stiffness_npm();
  return checked(std::move(grab));
}

Result<scene::Command> decode_drag(const v1::Drag& message) {
  if (!message.has_target()) return missing("drag.target");
  return checked(scene::Drag{message.grab_id(), decode_vector(message.target())});
}

Result<scene::Command> decode_release(const v1::Release& message) {
  return checked(scene::Release{message.grab_id()});
}

Result<scene::Command> decode_set_pins(const v1::SetPins& message) {
  KERF_TRY_ASSIGN(std::vector<scene::Region> pins, decode_pins(message.pins(), "set_pins.pins"));
  return checked(scene::SetPins{std::move(pins)});
}

Result<scene::Command> decode_set_gravity(const v1::SetGravity& message) {
  if (!message.has_gravity_mps2()) return missing("set_gravity.gravity_mps2");
  return checked(scene::SetGravity{decode_vector(message.gravity_mps2())});
}

Result<scene::Command> decode_set_wind(const v1::SetWind& message) {
  scene::SetWind set_wind;
  if (message.has_wind()) set_wind.wind = decode_wind(message.wind());
  return checked(set_wind);
}

Result<scene::Command> decode_set_material(const v1::SetMaterial& message) {
  if (!message.has_material()) return missing("set_material.material");
  KERF_TRY_ASSIGN(const fem::Material material, decode_material(message.material(), "set_material.material"));
  scene::SetMaterial set_material;
  set_material.material = material;
  if (message.has_part()) set_material.part = message.part();
  return checked(set_material);
}

Result<scene::Command> decode_set_self_contact(const v1::SetSelfContact& message) {
  KERF_TRY_ASSIGN(const scene::SetSelfContact set_self_contact, decode_self_contact_change(message));
  return checked(set_self_contact);
}

Result<scene::Command> decode_command(const v1::Command& message, const FileReader& read_file) {
  switch (message.kind_case()) {
    case v1::Command::kCut:
      return decode_cut(message.cut(), read_file);
    case v1::Command::kGrab:
      return decode_grab(message.grab());
    case v1::Command::kDrag:
      return decode_drag(message.drag());
    case v1::Command::kRelease:
      return decode_release(message.release());
    case v1::Command::kSetPins:
      return decode_set_pins(message.set_pins());
    case v1::Command::kSetGravity:
      return decode_set_gravity(message.set_gravity());
    case v1::Command::kSetWind:
      return decode_set_wind(message.set_wind());
    case v1::Command::kReset:
      return scene::Command(scene::Reset{message.reset().repeats()});
    case v1::Command::kCutBatch:
      return decode_cuts(message.cut_batch().cuts(), read_file);
    case v1::Command::kUndoCut:
      return scene::Command(scene::UndoCut{});
    case v1::Command::kRedoCut:
      return scene::Command(scene::RedoCut{});
    case v1::Command::kSetMaterial:
      return decode_set_material(message.set_material());
    case v1::Command::kSetSelfContact:
      return decode_set_self_contact(message.set_self_contact());
    case v1::Command::KIND_NOT_SET:
      break;
  }
  return choice_missing("kind",
                        "cut, grab, drag, release, set_pins, set_gravity, set_wind, reset, cut_batch, undo_cut, "
                        "redo_cut, set_material or set_self_contact");
}

v1::Command encode_command(const scene::Command& command) {
  v1::Command message;
  std::visit([&message](const auto& each) { encode(each, message); }, command);
  return message;
}

}  // namespace kerf::wire
