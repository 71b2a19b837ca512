#include "server/core/sheet/grab_set.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "server/core/scene/material_point.h"

namespace kerf::sheet {

namespace {

Error unknown_grab(const std::string& grab_id, const std::string& field) {
  return not_found("GRAB_NOT_FOUND", "the sheet has no grab \"" + grab_id + "\"", field);
}

// Returns mass of the sheet / dt^2 (N/m): the spring gives the whole sheet an acceleration of 1 mm per tick^2 for 1 mm
// of stretch. But it is no stiffer than the membrane, nor than kMaxGrabStiffness. So a jump of the target stretches the
// spring too, and not only the triangles at the point.
double default_stiffness(const mesh::TriangleMesh& mesh, const fem::Model& model, mesh::VertexId vertex, double dt) {
  const double hold = model.masses().total() / (dt * dt);
  const Eigen::Matrix3d& membrane = model.elements().law(mesh.triangle_at(vertex)).membrane;
  return std::min({hold, membrane.diagonal().maxCoeff(), scene::kMaxGrabStiffness});
}

}  // namespace

Status GrabSet::add(const scene::Grab& grab, const mesh::TriangleMesh& mesh, const fem::Model& model,
                    const linear::VertexField& x, double dt) {
  if (find(grab.grab_id) != grabs_.end()) {
    return already_exists("GRAB_EXISTS", "the sheet already has a grab \"" + grab.grab_id + "\"", "grab.grab_id");
  }
  if (grabs_.size() >= scene::kMaxGrabs) {
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
                              "grab.vertex is " + std::to_string(*vertex) + ", whose material a cut took away",
                              "grab.vertex");
    }
    held.vertices[0] = *vertex;
  } else {
    held.material = std::get<Eigen::Vector2d>(grab.point);
    const std::optional<scene::MaterialPoint> point = scene::find_material_point(mesh, *held.material);
    if (!point) return invalid_argument("POINT_OUTSIDE", "grab.material is not a point of the sheet", "grab.material");
    held.vertices = point->vertices;
    held.weights = point->weights;
  }
  const Eigen::Vector3d here = scene::MaterialPoint{held.vertices, held.weights}.of(x);
  held.target = grab.target.value_or(here);
  held.previous_target = here;
  held.is_default = grab.stiffness == 0.0;
  held.stiffness = held.is_default ? default_stiffness(mesh, model, held.vertices[0], dt) : grab.stiffness;
  grabs_.push_back(std::move(held));
  return Nothing{};
}

Status GrabSet::drag(const scene::Drag& drag) {
  const auto held = find(drag.grab_id);
  if (held == grabs_.end()) return unknown_grab(drag.grab_id, "drag.grab_id");
  held->target = drag.target;
  return Nothing{};
}

Status GrabSet::release(const scene::Release& release) {
  const auto held = find(release.grab_id);
  if (held == grabs_.end()) return unknown_grab(release.grab_id, "release.grab_id");
  grabs_.erase(held);
  return Nothing{};
}

void GrabSet::follow_material(const mesh::TriangleMesh& mesh, const fem::Model& model, double dt) {
  for (GrabState& held : grabs_) {
    if (held.is_default) held.stiffness = default_stiffness(mesh, model, held.vertices[0], dt);
  }
}

void GrabSet::leave_new_vertices(const VertexAncestry& ancestry, const mesh::TriangleMesh& mesh) {
  for (GrabState& held : grabs_) {
    const mesh::VertexId vertex = held.vertices[0];
    if (held.material || !ancestry.is_new(vertex)) continue;
    const mesh::VertexId ancestor = ancestry.ancestor(vertex);
    if (ancestor != mesh::kNone) {
      held.vertices[0] = ancestor;
    } else {
      held.material = mesh.rest_position(vertex);
    }
  }
}

void GrabSet::follow(const mesh::TriangleMesh& mesh) {
  for (GrabState& held : grabs_) {
    if (!held.material && !mesh.has_material(held.vertices[0])) held.material = mesh.rest_position(held.vertices[0]);
    if (!held.material) continue;
    const std::optional<scene::MaterialPoint> found = scene::find_material_point(mesh, *held.material);
    const scene::MaterialPoint point = found ? *found : scene::nearest_material_point(mesh, *held.material);
    held.vertices = point.vertices;
    held.weights = point.weights;
  }
}

void GrabSet::set(const fem::Integrator& integrator, const fem::Model& model, double dt,
                  std::vector<fem::Grab>& loads) const {
  loads.resize(grabs_.size());
  for (std::size_t i = 0; i < grabs_.size(); ++i) {
    const GrabState& from = grabs_[i];
    fem::Grab& to = loads[i];
    to.vertices = from.vertices;
    to.weights = from.weights;
    to.target = from.target;
    to.velocity = (from.target - from.previous_target) / dt;
    to.stiffness = from.stiffness;
    // Critical damping for the mass that moves with the held point.
    const double mobility = integrator.mobility(model, to);
    to.damping = mobility > 0.0 ? 2.0 * std::sqrt(from.stiffness / mobility) : 0.0;
  }
}

void GrabSet::end_step() {
  for (GrabState& grab : grabs_) grab.previous_target = grab.target;
}

void GrabSet::add_vertices_to(std::vector<mesh::VertexId>& vertices) const {
  for (const GrabState& held : grabs_) {
    const mesh::VertexId vertex = held.vertices[0];
    if (!held.material) vertices.insert(std::upper_bound(vertices.begin(), vertices.end(), vertex), vertex);
  }
}

void GrabSet::add_to(StateHash& hash) const {
  const auto add_vector = [&](const Eigen::Vector3d& value) {
    for (int k = 0; k < 3; ++k) hash.add(value[k]);
  };
  hash.add(static_cast<std::uint64_t>(grabs_.size()));
  for (const GrabState& grab : grabs_) {
    hash.add_span(std::span<const char>(grab.grab_id));
    for (std::size_t k = 0; k < 3; ++k) hash.add(grab.vertices[k]);
    add_vector(grab.weights);
    add_vector(grab.target);
    add_vector(grab.previous_target);
    hash.add(grab.stiffness);
  }
}

std::vector<GrabState>::iterator GrabSet::find(const std::string& grab_id) {
  return std::find_if(grabs_.begin(), grabs_.end(), [&](const GrabState& held) { return held.grab_id == grab_id; });
}

}  // namespace kerf::sheet
