#include <algorithm>
#include <limits>
#include <utility>

#include "server/cut/cut.h"
#include "server/fem/transfer.h"
#include "server/sheet/material_point.h"
#include "server/sheet/pins.h"
#include "server/sheet/sheet_impl.h"
#include "server/sheet/topology.h"

namespace kerf::sheet {

namespace {

// Skin friction beside pressure drag: the ratio of fem's default coefficients for cloth.
constexpr double kTangentialShare = 1.0 / 60.0;

// The point of edge k of t nearest to `at`.
MaterialPoint nearest_on_edge(const mesh::TriangleMesh& mesh, mesh::TriangleId t, int k, const Eigen::Vector2d& at) {
  MaterialPoint point;
  point.vertices = {mesh.vertices(t)[mesh::next_corner(k)], mesh.vertices(t)[mesh::previous_corner(k)],
                    mesh.vertices(t)[static_cast<std::size_t>(k)]};
  const Eigen::Vector2d a = mesh.rest_position(point.vertices[0]);
  const Eigen::Vector2d along = mesh.rest_position(point.vertices[1]) - a;
  const double share = std::clamp((at - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  point.weights = {1.0 - share, share, 0.0};
  return point;
}

// Where `at` is held when a cut has left it in the void: a border edge that a cut splits is rounded to the lattice and
// may bow inwards by half a unit, so material that lay exactly on it is then outside. Of equally near points, that of
// the lowest slot.
MaterialPoint nearest_material_point(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at) {
  MaterialPoint nearest;
  double least = std::numeric_limits<double>::infinity();
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (!mesh.is_solid(t) || mesh.neighbour(t, k) != mesh::kNone) continue;
      const MaterialPoint point = nearest_on_edge(mesh, t, k, at);
      const double distance = (point.weights[0] * mesh.rest_position(point.vertices[0]) +
                               point.weights[1] * mesh.rest_position(point.vertices[1]) - at)
                                  .squaredNorm();
      if (!(distance < least)) continue;  // also where the ends of a tiny edge round to one position, and it is NaN
      least = distance;
      nearest = point;
    }
  }
  return nearest;
}

Error unknown_grab(const std::string& grab_id, const std::string& field) {
  return {ErrorCode::kNotFound, "GRAB_NOT_FOUND", "the sheet has no grab \"" + grab_id + "\"", field};
}

// `remarks` come first.
std::vector<std::string> warnings_of(const cut::CutReport& report, const std::vector<std::string>& remarks) {
  std::vector<std::string> warnings = remarks;
  if (report.closed_gaps > 0) {
    warnings.push_back(std::to_string(report.closed_gaps) +
                       " gaps to older lips, the border or the path itself were closed");
  }
  if (report.merged_segments > 0) {
    warnings.push_back(std::to_string(report.merged_segments) + " segments shorter than the snap distance were merged");
  }
  if (report.triangles_behind > 0) {
    warnings.push_back(std::to_string(report.triangles_behind) +
                       " triangles reach behind the camera and were left out");
  }
  if (report.refinement_stopped) warnings.emplace_back("refinement stopped early: some new triangles are flat");
  return warnings;
}

}  // namespace

Result<CommandReply> Sheet::Impl::do_command(const Command& command, const CommandContext& context) {
  is_quiet = false;
  quiet_ticks = 0;
  if (Status s = validate(command); !s) return s.error();
  if (const auto* c = std::get_if<Cut>(&command)) return cut(*c, context);
  Status done = Nothing{};
  if (const auto* g = std::get_if<Grab>(&command)) {
    done = grab(*g);
  } else if (const auto* d = std::get_if<Drag>(&command)) {
    done = drag(*d);
  } else if (const auto* r = std::get_if<Release>(&command)) {
    done = release(*r);
  } else if (const auto* p = std::get_if<SetPins>(&command)) {
    done = set_pins(*p);
  } else if (const auto* gravity = std::get_if<SetGravity>(&command)) {
    loads.gravity = gravity->gravity;
    ++settings_version;
  } else if (const auto* w = std::get_if<SetWind>(&command)) {
    set_wind(w->wind);
    ++settings_version;
  } else {
    reset();
  }
  if (!done) return done.error();
  CommandReply reply;
  reply.topology_version = topology_version;
  return reply;
}

Result<CommandReply> Sheet::Impl::cut(const Cut& cut, const CommandContext& context) {
  cut::CutRequest request;
  request.curve = cut.curve;
  request.options.tolerance = cut.tolerance;
  request.options.min_angle_deg = cut.min_angle_deg;
  request.options.max_new_triangles = cut.max_new_triangles;
  request.options.max_vertices = config->max_vertices;
  request.options.fit = cut.fit;
  request.options.dash = cut.dash;
  request.fixed_vertices = vertices_that_stay();
  request.view = cut.view;
  request.positions = &state.x;

  const auto carry_out = [&]() -> Result<cut::CutOutcome> {
    const StageScope scope(context.observer, Stage::kCut, context.index);
    const Result<cut::CutPlan> plan = cut::plan(mesh, request);
    if (!plan) return plan.error();
    return cut::apply(mesh, *plan);
  };
  const Result<cut::CutOutcome> outcome = carry_out();
  if (!outcome) return outcome.error();

  if (outcome->status == cut::CutStatus::kApplied) {
    const StageScope scope(context.observer, Stage::kModelUpdate, context.index);
    follow(outcome->edit);
    ++num_cuts;
  }
  CommandReply reply;
  reply.topology_version = topology_version;
  reply.cut = CutReply{outcome->status, outcome->report, warnings_of(outcome->report, cut.remarks)};
  reply.cut->report.pieces = mesh.num_pieces();
  return reply;
}

Status Sheet::Impl::grab(const Grab& grab) {
  if (find_grab(grab.grab_id) != grabs.end()) {
    return Error{ErrorCode::kAlreadyExists, "GRAB_EXISTS", "the sheet already has a grab \"" + grab.grab_id + "\"",
                 "grab.grab_id"};
  }
  if (grabs.size() >= kMaxGrabs) {
    return Error{ErrorCode::kResourceExhausted, "TOO_MANY_GRABS", "a sheet has at most 64 grabs; release one first",
                 "grab.grab_id"};
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
  held.stiffness = grab.stiffness > 0.0 ? grab.stiffness : default_stiffness();
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
  Result<std::vector<mesh::VertexId>> found = find_pinned(mesh, pins.pins, "set_pins.pins");
  if (!found) return found.error();
  pin(std::move(found).value());
  ++settings_version;
  return Nothing{};
}

void Sheet::Impl::set_wind(const Wind& value) {
  wind = value;
  loads.wind.velocity = value.velocity;
  loads.wind.air_density = value.air_density;
  loads.wind.normal_drag = value.drag_coefficient;
  loads.wind.tangential_drag = kTangentialShare * value.drag_coefficient;
}

void Sheet::Impl::reset() {
  mesh = initial->mesh;
  state.x = initial->positions;
  state.v = Eigen::Matrix3Xd::Zero(3, initial->positions.cols());
  model = fem::Model(mesh, config->material);
  grabs.clear();
  loads.gravity = config->gravity;
  set_wind(config->wind);
  pin(initial->pinned);
  rebuild();
  frozen = false;
  failed_steps = 0;
  ++topology_version;
  ++settings_version;
  topology = full_topology(mesh, topology_version);
}

// Brings everything that is derived from the mesh up to date with an edit of it.
void Sheet::Impl::follow(const mesh::MeshEdit& edit) {
  const fem::MassChange change = model.apply(mesh, edit);
  fem::transfer_state(edit, model, change, state);
  std::vector<mesh::VertexId> inherited = pinned;
  inherit_pins(edit, inherited);
  // Old pins keep their targets: nothing may have moved them. The new ones are held where they are.
  for (const fem::Pin& p : loads.pins) state.x.col(p.vertex) = p.target;
  pin(std::move(inherited));
  for (GrabState& held : grabs) {
    if (!held.material) continue;
    const std::optional<MaterialPoint> found = find_material_point(mesh, *held.material);
    const MaterialPoint point = found ? *found : nearest_material_point(mesh, *held.material);
    held.vertices = point.vertices;
    held.weights = point.weights;
  }
  rebuild();
  ++topology_version;
  topology = edited_topology(*topology, mesh, edit, topology_version);
}

// Holds `vertices` (sorted, unique) where they are now.
void Sheet::Impl::pin(std::vector<mesh::VertexId> vertices) {
  pinned = std::move(vertices);
  loads.pins.clear();
  loads.pins.reserve(pinned.size());
  for (const mesh::VertexId v : pinned) {
    state.v.col(v).setZero();
    loads.pins.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
  }
  contact.set_vertices(mesh.num_vertices(), pinned);
}

// After the model changed; all that a step needs is allocated here.
void Sheet::Impl::rebuild() {
  integrator->rebuild(model);
  integrator_description = std::string(integrator->explanation());
  last_good.x.resize(3, state.x.cols());
  last_good.v.resize(3, state.v.cols());
}

std::vector<GrabState>::iterator Sheet::Impl::find_grab(const std::string& grab_id) {
  return std::find_if(grabs.begin(), grabs.end(), [&](const GrabState& held) { return held.grab_id == grab_id; });
}

std::vector<mesh::VertexId> Sheet::Impl::vertices_that_stay() const {
  std::vector<mesh::VertexId> vertices = pinned;
  for (const GrabState& held : grabs) {
    if (!held.material) vertices.push_back(held.vertices[0]);
  }
  return vertices;
}

// N/m. Holds the whole sheet against an acceleration of 1 mm a tick squared with 1 mm of stretch, but is no stiffer
// than the membrane, so that a jump of the target stretches the spring and not only the triangles it is tied to.
double Sheet::Impl::default_stiffness() const {
  const double hold = model.total_mass() / (dt * dt);
  return std::min({hold, model.membrane_law().diagonal().maxCoeff(), kMaxGrabStiffness});
}

}  // namespace kerf::sheet
