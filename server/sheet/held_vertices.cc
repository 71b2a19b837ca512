#include "server/sheet/held_vertices.h"

#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

namespace kerf::sheet {

namespace {

using mesh::VertexId;

Eigen::Matrix3d turn(const Rotation& rotation, double factor) {
  return Eigen::AngleAxisd(factor * rotation.angle, rotation.axis.normalized()).toRotationMatrix();
}

bool is_over(const Constraint& constraint, const Instant& now) {
  return constraint.until && now.time >= *constraint.until;
}

// Of x by the material coordinates, the mean over the triangles around v.
Eigen::Matrix<double, 3, 2> gradient_at(const mesh::TriangleMesh& mesh, VertexId v, const mesh::VertexField& x,
                                        std::vector<mesh::TriangleId>& fan) {
  Eigen::Matrix<double, 3, 2> sum = Eigen::Matrix<double, 3, 2>::Zero();
  mesh.triangles_around(v, fan);
  for (const mesh::TriangleId t : fan) {
    const std::array<VertexId, 3> corner = mesh.vertices(t);
    Eigen::Matrix2d rest;
    rest << mesh.rest_position(corner[1]) - mesh.rest_position(corner[0]),
        mesh.rest_position(corner[2]) - mesh.rest_position(corner[0]);
    Eigen::Matrix<double, 3, 2> edges;
    edges << x.col(corner[1]) - x.col(corner[0]), x.col(corner[2]) - x.col(corner[0]);
    sum += edges * rest.inverse();
  }
  return sum / static_cast<double>(fan.size());
}

// In the plane x[component] = const that all vertices start in.
int find_plane(const mesh::TriangleMesh& mesh, const mesh::VertexField& x) {
  const double slack = kRegionTolerance * mesh.bounding_box().sizes().maxCoeff();
  for (int k = 2; k >= 0; --k) {
    if (x.row(k).maxCoeff() - x.row(k).minCoeff() <= slack) return k;
  }
  return -1;
}

}  // namespace

Result<HeldVertices> HeldVertices::create(std::shared_ptr<const SheetConfig> config, const mesh::TriangleMesh& mesh,
                                          const mesh::VertexField& x) {
  HeldVertices held(std::move(config));
  std::vector<mesh::TriangleId> fan;
  for (std::size_t c = 0; c < held.constraints().size(); ++c) {
    const Constraint& constraint = held.constraints()[c];
    const std::string field = "constraints[" + std::to_string(c) + "].region";
    const Result<std::vector<VertexId>> found = find_vertices(mesh, constraint.region, field);
    if (!found) return found.error();
    Group group(found->size());
    for (std::size_t i = 0; i < group.size(); ++i) {
      Start& start = group[i];
      start.vertex = (*found)[i];
      start.material = mesh.rest_position(start.vertex);
      start.x = x.col(start.vertex);
      start.displacement = constraint.displacement;
      if (constraint.slope) start.gradient = gradient_at(mesh, start.vertex, x, fan);
    }
    if (constraint.displacements.cols() > 0) {
      const auto& listed = std::get<std::vector<VertexId>>(constraint.region);
      for (std::size_t k = 0; k < listed.size(); ++k) {
        const auto at = std::lower_bound(found->begin(), found->end(), listed[k]) - found->begin();
        group[static_cast<std::size_t>(at)].displacement = constraint.displacements.col(static_cast<Eigen::Index>(k));
      }
    }
    if (!constraint.history.times.empty())
      held.last_change_ = std::max(held.last_change_, constraint.history.times.back());
    if (constraint.until) held.last_change_ = std::max(held.last_change_, *constraint.until);
    held.groups_.push_back(std::move(group));
  }
  if (held.config_->planar) {
    const int component = find_plane(mesh, x);
    if (component < 0) {
      return invalid_argument("NOT_PLANAR",
                              "planar asks for a sheet that starts in a plane perpendicular to x, y or z; turn its "
                              "placement",
                              "planar");
    }
    held.plane_ = Plane{component, x(component, 0)};
  }
  return held;
}

bool HeldVertices::has_slopes() const {
  return std::any_of(constraints().begin(), constraints().end(), [](const Constraint& c) { return c.slope; });
}

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
      const double weight = added.weights[k];
      if (weight <= 0.0) continue;
      const Start* const source = find(added.sources[static_cast<std::size_t>(k)]);
      all = source != nullptr;
      if (!all) continue;
      start.x += weight * source->x;
      start.displacement += weight * source->displacement;
      start.gradient += weight * source->gradient;
    }
    if (all) group.push_back(start);  // ids are consecutive beyond all old ones, so the order holds
  }
}

void HeldVertices::follow(const mesh::TriangleMesh& mesh, std::span<const mesh::MeshEdit* const> edits,
                          const Instant& now, const mesh::VertexField& x) {
  std::vector<mesh::TriangleId> fan;
  for (std::size_t c = 0; c < groups_.size(); ++c) {
    const Constraint& constraint = constraints()[c];
    Group& group = groups_[c];
    for (const mesh::MeshEdit* const edit : edits) inherit(*edit, group);
    const bool is_list = std::holds_alternative<std::vector<VertexId>>(constraint.region);
    if (is_list) {
      std::erase_if(group,
                    [&](const Start& s) { return s.vertex >= mesh.num_vertices() || !mesh.has_material(s.vertex); });
    } else {
      // Regions of places name no vertex that might be missing.
      const std::vector<VertexId> found = find_vertices(mesh, constraint.region, "").value();
      Group looked_up(found.size());
      auto known = group.begin();
      for (std::size_t i = 0; i < found.size(); ++i) {
        Start& start = looked_up[i];
        while (known != group.end() && known->vertex < found[i]) ++known;
        if (known != group.end() && known->vertex == found[i]) {
          start = *known;
          continue;
        }
        const double factor = constraint.history.at(now.time, now.absent);
        start.vertex = found[i];
        start.displacement = constraint.displacement;
        if (constraint.slope) start.gradient = gradient_at(mesh, start.vertex, x, fan);
        start.x = x.col(start.vertex) -
                  factor * (constraint.displacement + constraint.stretch * mesh.rest_position(start.vertex));
        if (constraint.rotation) {
          const Eigen::Matrix3d back = turn(*constraint.rotation, -factor);
          start.x = constraint.rotation->centre + back * (start.x - constraint.rotation->centre);
          start.gradient = back * start.gradient;
        }
      }
      group = std::move(looked_up);
    }
    for (Start& start : group) start.material = mesh.rest_position(start.vertex);
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
    const auto place = [&](const Start& start, double f, const Eigen::Matrix3d& R) -> Eigen::Vector3d {
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
      const Eigen::Vector3d target = place(start, factor, R_end);
      const Eigen::Vector3d velocity = moves ? Eigen::Vector3d((target - place(start, before, R_begin)) / dt)
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
  // Of several that hold a vertex, the last, as with its place.
  std::stable_sort(clamps.begin(), clamps.end(),
                   [](const fem::Clamp& a, const fem::Clamp& b) { return a.vertex < b.vertex; });
  std::vector<fem::Clamp> last;
  for (const fem::Clamp& clamp : clamps) {
    if (!last.empty() && last.back().vertex == clamp.vertex) last.pop_back();
    last.push_back(clamp);
  }
  return last;
}

}  // namespace kerf::sheet
