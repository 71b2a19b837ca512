#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "server/base/overloaded.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/model/condition.h"
#include "server/core/scene/integrator_settings.h"
#include "server/core/scene/material_point.h"
#include "server/core/scene/region.h"
#include "server/core/sheet/sheet_impl.h"

namespace kerf::sheet {

namespace {

// Skin friction beside pressure drag: the ratio of fem's default coefficients for cloth.
constexpr double kTangentialShare = 1.0 / 60.0;

Error unknown_grab(const std::string& grab_id, const std::string& field) {
  return not_found("GRAB_NOT_FOUND", "the sheet has no grab \"" + grab_id + "\"", field);
}

std::string millimetres(double metres) {
  std::array<char, 32> text{};
  const double mm = 1e3 * metres;
  std::snprintf(text.data(), text.size(), mm < 100.0 ? "%.2g mm" : "%.0f mm", mm);
  return text.data();
}

// `remarks` come first. Closed gaps and merged segments are below the cut's tolerance, so that the report alone has
// them.
std::vector<std::string> warnings_of(const cut::CutReport& report, const std::vector<std::string>& remarks) {
  std::vector<std::string> warnings = remarks;
  if (report.triangles_behind > 0) {
    warnings.push_back("triangles that reach behind the camera, left out: " + std::to_string(report.triangles_behind));
  }
  if (report.view_deviation_m > 0.0) {
    warnings.push_back("seen nearly edge-on: the cut is up to " + millimetres(report.view_deviation_m) +
                       " off the sight lines");
  }
  if (report.refinement_stopped) warnings.emplace_back("refinement stopped early: some new triangles are flat");
  return warnings;
}

}  // namespace

Result<CommandReply> Sheet::Impl::do_command(const Command& command, const CommandContext& context) {
  rest.disturb();
  KERF_TRY(validate(command));
  const auto plain = [this](const Status& done) -> Result<CommandReply> {
    KERF_TRY(done);
    return plain_reply();
  };
  return std::visit(Overloaded{
                        [&](const Cut& asked) { return cut(asked, context); },
                        [&](const CutBatch& asked) { return cut_batch(asked, context); },
                        [&](const UndoCut& /*asked*/) { return undo_cut(context); },
                        [&](const RedoCut& /*asked*/) { return redo_cut(context); },
                        [&](const Grab& asked) { return plain(grab(asked)); },
                        [&](const Drag& asked) { return plain(drag(asked)); },
                        [&](const Release& asked) { return plain(release(asked)); },
                        [&](const SetPins& asked) { return plain(set_pins(asked)); },
                        [&](const SetGravity& asked) {
                          set_gravity(asked.gravity);
                          return plain(Nothing{});
                        },
                        [&](const SetWind& asked) {
                          set_wind(asked.wind);
                          ++settings_version;
                          return plain(Nothing{});
                        },
                        [&](const SetMaterial& asked) { return plain(set_material(asked)); },
                        [&](const Reset& asked) {
                          reset(asked);
                          return plain(Nothing{});
                        },
                    },
                    command);
}

cut::CutRequest Sheet::Impl::request_of(const Cut& cut) const {
  cut::CutRequest request;
  request.curve = cut.curve;
  request.options = cut.options;
  request.view = cut.view;
  request.max_vertices = std::min(config->max_vertices, vertex_limit(config->integrator));
  return request;
}

CutReply Sheet::Impl::reply_of(const cut::CutOutcome& outcome, const Cut& cut, double mass_before) const {
  CutReply reply;
  reply.status = outcome.status;
  reply.report = outcome.report;
  reply.report.pieces = mesh.num_pieces();
  reply.warnings = warnings_of(outcome.report, cut.remarks);
  if (cut.options.width_m && outcome.status == cut::CutStatus::kApplied) {
    const fem::Material& material = materials->by_region[0];
    const double density = material.density * material.thickness;
    reply.removed_mass = has_one_material() ? density * outcome.report.removed_area_m2 : mass_before - rest_mass();
  }
  return reply;
}

double Sheet::Impl::rest_mass() const {
  double mass = 0.0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) mass += surface_density(mesh, t, materials->by_region) * mesh.area(t);
  }
  return mass;
}

Status Sheet::Impl::grab(const Grab& grab) {
  if (find_grab(grab.grab_id) != grabs.end()) {
    return already_exists("GRAB_EXISTS", "the sheet already has a grab \"" + grab.grab_id + "\"", "grab.grab_id");
  }
  if (grabs.size() >= kMaxGrabs) {
    return resource_exhausted("TOO_MANY_GRABS", "a sheet has at most 64 grabs; release one first", "grab.grab_id");
  }
  GrabState held;
  held.grab_id = grab.grab_id;
  if (const auto* vertex = std::get_if<mesh::VertexId>(&grab.point)) {
    if (*vertex >= mesh.num_vertices()) {
      return invalid_argument("UNKNOWN_VERTEX",
                              "grab.vertex is " + std::to_string(*vertex) + "; the sheet has vertices 0.." +
                                  std::to_string(mesh.num_vertices() - 1),
                              "grab.vertex");
    }
    if (!mesh.has_material(*vertex)) {
      return invalid_argument("UNKNOWN_VERTEX",
                              "grab.vertex is " + std::to_string(*vertex) + ", whose material a cut removed",
                              "grab.vertex");
    }
    held.vertices[0] = *vertex;
  } else {
    held.material = std::get<Eigen::Vector2d>(grab.point);
    const std::optional<MaterialPoint> point = find_material_point(mesh, *held.material);
    if (!point) return invalid_argument("POINT_OUTSIDE", "grab.material is not a point of the sheet", "grab.material");
    held.vertices = point->vertices;
    held.weights = point->weights;
  }
  Eigen::Vector3d here = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    if (held.vertices[k] != mesh::kNone)
      here += held.weights[static_cast<Eigen::Index>(k)] * state.x.col(held.vertices[k]);
  }
  held.target = grab.target.value_or(here);
  held.previous_target = here;
  held.is_default = grab.stiffness == 0.0;
  held.stiffness = held.is_default ? default_stiffness(held.vertices[0]) : grab.stiffness;
  grabs.push_back(std::move(held));
  return Nothing{};
}

Status Sheet::Impl::drag(const Drag& drag) {
  const auto held = find_grab(drag.grab_id);
  if (held == grabs.end()) return unknown_grab(drag.grab_id, "drag.grab_id");
  held->target = drag.target;
  return Nothing{};
}

Status Sheet::Impl::release(const Release& release) {
  const auto held = find_grab(release.grab_id);
  if (held == grabs.end()) return unknown_grab(release.grab_id, "release.grab_id");
  grabs.erase(held);
  return Nothing{};
}

Status Sheet::Impl::set_pins(const SetPins& pins) {
  KERF_TRY_ASSIGN(std::vector<mesh::VertexId> found, find_pins(mesh, pins.pins, "set_pins.pins"));
  pin(std::move(found));
  pins_version = ++last_pins_version;
  ++settings_version;
  return Nothing{};
}

void Sheet::Impl::set_gravity(const Eigen::Vector3d& value) {
  full_gravity = value;
  conditions_changed = true;
  ++settings_version;
}

void Sheet::Impl::set_wind(const Wind& value) {
  wind = value;
  loads.wind.velocity = value.velocity;
  loads.wind.air_density = value.air_density;
  loads.wind.normal_drag = value.drag_coefficient;
  loads.wind.tangential_drag = kTangentialShare * value.drag_coefficient;
  last_counts.reset();
}

CommandReply Sheet::Impl::plain_reply() const {
  CommandReply reply;
  reply.topology_version = topology_version;
  reply.beginning = beginning;
  return reply;
}

void hold(const std::vector<mesh::VertexId>& vertices, fem::State& state, std::vector<fem::Pin>& holds) {
  holds.clear();
  holds.reserve(vertices.size());
  for (const mesh::VertexId v : vertices) {
    state.v.col(v).setZero();
    holds.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
  }
}

// Holds `vertices` (sorted, unique) where they are now.
void Sheet::Impl::pin(std::vector<mesh::VertexId> vertices) {
  pinned = std::move(vertices);
  hold(pinned, state, holds);
  conditions_changed = true;
  contact.set_vertices(mesh.num_vertices(), pinned, removed);
}

// Rebuilds the integrator after the model was rebuilt.
void Sheet::Impl::rebuild() {
  integrator->rebuild(model);
  make_room();
}

// Allocates all that a step needs, once the integrator follows the model.
void Sheet::Impl::make_room() {
  integrator_description =
      std::string(integrator->explanation()) + "; " + fem::describe_condition(fem::condition_number(model, dt));
  if (softening) integrator_description += "; " + fem::describe(*softening);
  last_good.x.resize(state.x.cols());
  last_good.v.resize(state.v.cols());
  rest.make_room(state.x.cols());
}

std::vector<GrabState>::iterator Sheet::Impl::find_grab(const std::string& grab_id) {
  return std::find_if(grabs.begin(), grabs.end(), [&](const GrabState& held) { return held.grab_id == grab_id; });
}

// Returns the stiffness that holds the whole sheet against an acceleration of 1 mm a tick squared with 1 mm of stretch.
// It is no stiffer than the membrane, nor than kMaxGrabStiffness. So a jump of the target stretches the spring and not
// only the triangles it is tied to.
double Sheet::Impl::default_stiffness(mesh::VertexId vertex) const {
  const double hold = model.total_mass() / (dt * dt);
  const Eigen::Matrix3d& membrane = model.law(mesh.triangle_at(vertex)).membrane;
  return std::min({hold, membrane.diagonal().maxCoeff(), kMaxGrabStiffness});
}

}  // namespace kerf::sheet
