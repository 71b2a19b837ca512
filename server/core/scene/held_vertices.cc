#include "server/core/scene/held_vertices.h"

#include <algorithm>
#include <utility>

#include "server/core/linear/rotation.h"
#include "server/core/scene/material_point.h"
#include "server/core/scene/region.h"

namespace kerf::scene {

namespace {

using mesh::VertexId;

Eigen::Matrix3d turn(const Rotation& rotation, double factor) {
  return linear::rotation_about(rotation.axis.normalized(), factor * rotation.angle);
}

bool is_over(const Constraint& constraint, const Instant& now) {
  return constraint.until && now.time >= *constraint.until;
}

// Returns the component k (0 to 2) of a plane x[k] = const in which all vertices start, or -1 if there is none.
int find_plane(const mesh::TriangleMesh& mesh, const Eigen::Matrix3Xd& x) {
  const double slack = kRegionTolerance * mesh.bounding_box().sizes().maxCoeff();
  for (int k = 2; k >= 0; --k) {
    if (x.row(k).maxCoeff() - x.row(k).minCoeff() <= slack) return k;
  }
  return -1;
}

}  // namespace

void HeldVertices::place(const Constraint& constraint, const BuiltMesh& initial, Start& start) {
  const MaterialPoint point = initial.at(start.material);
  start.x = point.of(initial.positions);
  if (constraint.slope) start.gradient = initial.gradient_at(point);
}

Result<HeldVertices> HeldVertices::create(std::shared_ptr<const SheetConfig> config, const BuiltMesh& initial) {
  HeldVertices held(std::move(config));
  for (std::size_t c = 0; c < held.constraints().size(); ++c) {
    const Constraint& constraint = held.constraints()[c];
    const std::string field = "constraints[" + std::to_string(c) + "].region";
    KERF_TRY_ASSIGN(const PlacedRegion region, scene::place(constraint.region, initial.components, field));
    KERF_TRY_ASSIGN(const std::vector<VertexId> found, find_vertices(initial.mesh, region, field));
    const bool is_listed = std::holds_alternative<std::vector<VertexId>>(region.shape);
    if (found.empty() && (is_listed || !schedules_cuts(*held.config_))) return no_vertex_in(field);
    Group group(found.size());
    for (std::size_t i = 0; i < group.size(); ++i) {
      group[i].vertex = found[i];
      group[i].material = initial.mesh.rest_position(group[i].vertex);
      group[i].displacement = constraint.displacement;
      place(constraint, initial, group[i]);
      group[i].x = initial.positions.col(group[i].vertex);  // the given start position, without rounding by
                                                            // interpolation
    }
    if (constraint.displacements.cols() > 0) {
      const auto& listed = std::get<std::vector<VertexId>>(region.shape);
      for (std::size_t k = 0; k < listed.size(); ++k) {
        const auto at = std::lower_bound(found.begin(), found.end(), listed[k]) - found.begin();
        group[static_cast<std::size_t>(at)].displacement = constraint.displacements.col(static_cast<Eigen::Index>(k));
      }
    }
    if (!constraint.history.times.empty()) {
      held.last_change_ = std::max(held.last_change_, constraint.history.times.back());
    }
    if (constraint.until) held.last_change_ = std::max(held.last_change_, *constraint.until);
    held.groups_.push_back(std::move(group));
  }
  if (held.config_->planar) {
    const int component = find_plane(initial.mesh, initial.positions);
    if (component < 0) {
      return invalid_argument("NOT_PLANAR",
                              "planar requires a sheet that starts in a plane perpendicular to x, y or z; turn its "
                              "placement",
                              "planar");
    }
    held.plane_ = Plane{component, initial.positions(component, 0)};
  }
  return held;
}

bool HeldVertices::has_slopes() const {
  return std::any_of(constraints().begin(), constraints().end(), [](const Constraint& c) { return c.slope; });
}

// Adds the new vertices of an edit all of whose sources are held.
void HeldVertices::inherit(const mesh::MeshEdit& edit, Group& group) {
  const std::size_t num_before = group.size();
  const auto find = [&](VertexId v) -> const Start* {
    const auto end = group.begin() + static_cast<std::ptrdiff_t>(num_before);
    const auto at = std::lower_bound(group.begin(), end, v, [](const Start& s, VertexId id) { return s.vertex < id; });
    return at != end && at->vertex == v ? &*at : nullptr;
  };
  for (const mesh::VertexSource& added : edit.added_vertices) {
    Start start;
    start.vertex = added.vertex;
    bool all = true;
    for (int k = 0; k < 3 && all; ++k) {
      if (added.weights[k] <= 0.0) continue;
      const Start* const source = find(added.sources[static_cast<std::size_t>(k)]);
      all = source != nullptr;
      if (all) start.displacement += added.weights[k] * source->displacement;
    }
    if (all) group.push_back(start);  // new ids are higher than all old ones, so the order is kept
  }
}

void HeldVertices::follow(const mesh::TriangleMesh& mesh, std::span<const mesh::MeshEdit* const> edits,
                          const BuiltMesh& initial) {
  for (std::size_t c = 0; c < groups_.size(); ++c) {
    const Constraint& constraint = constraints()[c];
    Group& group = groups_[c];
    if (std::holds_alternative<std::vector<VertexId>>(constraint.region.shape)) {
      for (const mesh::MeshEdit* const edit : edits) inherit(*edit, group);
      std::erase_if(group,
                    [&](const Start& s) { return s.vertex >= mesh.num_vertices() || !mesh.has_material(s.vertex); });
    } else {
      // These regions name places, so no vertex can be unknown; components were checked when the sheet was made.
      const PlacedRegion region = scene::place(constraint.region, initial.components, "").value();
      Group known;
      known.swap(group);
      auto at = known.begin();
      const std::vector<VertexId> found = find_vertices(mesh, region, "").value();
      for (const VertexId v : found) {
        while (at != known.end() && at->vertex < v) ++at;
        const bool is_known = at != known.end() && at->vertex == v;
        group.push_back(is_known ? *at : Start{});
        group.back().vertex = v;
        group.back().displacement = constraint.displacement;
      }
    }
    for (Start& start : group) {
      const Eigen::Vector2d material = mesh.rest_position(start.vertex);
      if (start.material == material && start.vertex < initial.mesh.num_vertices()) continue;  // unchanged
      start.material = material;
      place(constraint, initial, start);
    }
  }
}

void HeldVertices::set(std::span<const fem::Pin> pins, const Instant& begin, const Instant& end, double dt,
                       const mesh::TriangleMesh& mesh, std::vector<fem::Pin>& held) const {
  held.assign(pins.begin(), pins.end());
  if (plane_) {
    std::vector<fem::Pin> all;
    auto pin = held.begin();
    for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
      while (pin != held.end() && pin->vertex < v) ++pin;
      if (!mesh.has_material(v)) continue;
      fem::Pin flat;
      if (pin != held.end() && pin->vertex == v)
        flat = *pin;
      else
        flat.fixed = {false, false, false};
      flat.vertex = v;
      flat.fixed[static_cast<std::size_t>(plane_->component)] = true;
      flat.target[plane_->component] = plane_->at;
      flat.velocity[plane_->component] = 0.0;
      all.push_back(flat);
    }
    held = std::move(all);
  }
  for (std::size_t c = 0; c < groups_.size(); ++c) {
    const Constraint& constraint = constraints()[c];
    if (is_over(constraint, end)) continue;
    const double factor = constraint.history.at(end.time, end.absent);
    const double before = dt > 0.0 ? constraint.history.at(begin.time, begin.absent) : factor;
    const bool moves = before != factor;
    const auto path = [&](const Start& start, double f, const Eigen::Matrix3d& R) -> Eigen::Vector3d {
      const Eigen::Vector3d shift = f * (start.displacement + constraint.stretch * start.material);
      if (!constraint.rotation) return start.x + shift;
      return constraint.rotation->centre + R * (start.x - constraint.rotation->centre) + shift;
    };
    Eigen::Matrix3d R_end = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d R_begin = Eigen::Matrix3d::Identity();
    if (constraint.rotation) {
      R_end = turn(*constraint.rotation, factor);
      R_begin = turn(*constraint.rotation, before);
    }
    const std::size_t num_before = held.size();
    auto at = held.begin();
    for (const Start& start : groups_[c]) {
      const auto known_end = held.begin() + static_cast<std::ptrdiff_t>(num_before);
      while (at != known_end && at->vertex < start.vertex) ++at;
      fem::Pin pin;
      const bool is_known = at != known_end && at->vertex == start.vertex;
      if (is_known) {
        pin = *at;
      } else {
        pin.fixed = {false, false, false};
      }
      pin.vertex = start.vertex;
      const Eigen::Vector3d target = path(start, factor, R_end);
      const Eigen::Vector3d velocity = moves ? Eigen::Vector3d((target - path(start, before, R_begin)) / dt)
                                             : Eigen::Vector3d(Eigen::Vector3d::Zero());
      for (std::size_t k = 0; k < 3; ++k) {
        if (!constraint.held[k]) continue;
        const auto component = static_cast<Eigen::Index>(k);
        pin.fixed[k] = true;
        pin.target[component] = target[component];
        pin.velocity[component] = velocity[component];
      }
      if (is_known) {
        *at = pin;
      } else {
        const auto offset = at - held.begin();
        held.push_back(pin);
        at = held.begin() + offset;
      }
    }
    std::inplace_merge(held.begin(), held.begin() + static_cast<std::ptrdiff_t>(num_before), held.end(),
                       [](const fem::Pin& a, const fem::Pin& b) { return a.vertex < b.vertex; });
  }
}

std::vector<fem::Clamp> HeldVertices::clamps(const Instant& now) const {
  std::vector<fem::Clamp> clamps;
  for (std::size_t c = 0; c < groups_.size(); ++c) {
    const Constraint& constraint = constraints()[c];
    if (!constraint.slope || is_over(constraint, now)) continue;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    if (constraint.rotation) R = turn(*constraint.rotation, constraint.history.at(now.time, now.absent));
    for (const Start& start : groups_[c]) clamps.push_back({start.vertex, R * start.gradient});
  }
  // If several clamps hold a vertex, the last one counts, as for positions.
  std::stable_sort(clamps.begin(), clamps.end(),
                   [](const fem::Clamp& a, const fem::Clamp& b) { return a.vertex < b.vertex; });
  std::vector<fem::Clamp> last;
  for (const fem::Clamp& clamp : clamps) {
    if (!last.empty() && last.back().vertex == clamp.vertex) last.pop_back();
    last.push_back(clamp);
  }
  return last;
}

}  // namespace kerf::scene
