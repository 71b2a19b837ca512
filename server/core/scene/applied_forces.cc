#include "server/core/scene/applied_forces.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "server/core/scene/material_point.h"
#include "server/core/scene/region.h"

namespace kerf::scene {

namespace {

using mesh::VertexId;

double total_length(const std::vector<BorderEdge>& edges) {
  double sum = 0.0;
  for (const BorderEdge& edge : edges) sum += edge.length;
  return sum;
}

// Returns the vertices of the region, which was checked when the sheet was made. Leaves out listed vertices that cuts
// or undos have removed or left without material.
std::vector<VertexId> vertices_of(const mesh::TriangleMesh& mesh, const Region& region, const BuiltMesh& initial) {
  PlacedRegion placed = place(region, initial.components, "").value();
  forget_removed(mesh, placed);
  return find_vertices(mesh, placed, "").value();
}

// Returns the outward normal of a border edge: a unit vector in the world, in the plane of the sheet as it starts, away
// from the material.
Eigen::Vector3d outward_normal(const mesh::TriangleMesh& mesh, const BorderEdge& edge, const BuiltMesh& initial) {
  const std::array<VertexId, 3>& corner = mesh.vertices(edge.slot);
  const Eigen::Vector2d centroid =
      (mesh.rest_position(corner[0]) + mesh.rest_position(corner[1]) + mesh.rest_position(corner[2])) / 3.0;
  const Eigen::Vector2d along = mesh.rest_position(edge.ends[1]) - mesh.rest_position(edge.ends[0]);
  const Eigen::Matrix<double, 3, 2> gradient = initial.gradient_at(initial.at(centroid));
  const Eigen::Vector3d tangent = (gradient * along).normalized();
  const Eigen::Vector3d right = gradient * Eigen::Vector2d(along.y(), -along.x());
  return (right - right.dot(tangent) * tangent).normalized();
}

struct Place {
  const Region* region = nullptr;
  const char* name = "";
  bool is_border = false;
};

// Finds the region on which a load acts, the name of its field, and whether border edges carry the load. A PointForce
// has no region.
struct FindPlace {
  Place operator()(const PointForce&) const { return {}; }
  Place operator()(const EdgeForce& load) const { return {&load.region, "edge", true}; }
  Place operator()(const AreaForce& load) const { return {&load.region, "area", false}; }
  Place operator()(const Pressure& load) const { return {&load.region, "pressure", false}; }
  Place operator()(const EdgeMoment& load) const { return {&load.region, "moment", true}; }
};

Status check_point(const PointForce& point, const mesh::TriangleMesh& mesh, const std::string& path) {
  if (const auto* vertex = std::get_if<VertexId>(&point.point)) {
    const std::string field = path + ".point.vertex";
    if (find_vertices(mesh, {std::vector<VertexId>{*vertex}}, field).ok()) return Nothing{};
    return invalid_argument("UNKNOWN_VERTEX",
                            field + " is " + std::to_string(*vertex) + "; the sheet has vertices 0.." +
                                std::to_string(mesh.num_vertices() - 1),
                            field);
  }
  if (find_material_point(mesh, std::get<Eigen::Vector2d>(point.point))) return Nothing{};
  const std::string field = path + ".point.material";
  return invalid_argument("POINT_OUTSIDE", field + " is not a point of the sheet", field);
}

}  // namespace

Result<AppliedForces> AppliedForces::create(std::shared_ptr<const SheetConfig> config, const BuiltMesh& initial) {
  const mesh::TriangleMesh& mesh = initial.mesh;
  AppliedForces forces(std::move(config));
  const std::vector<Load>& loads = forces.config_->loads;
  forces.shares_.resize(loads.size());
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const std::string path = "loads[" + std::to_string(i) + "]";
    if (const auto* point = std::get_if<PointForce>(&loads[i].kind)) {
      KERF_TRY(check_point(*point, mesh, path));
      const auto* vertex = std::get_if<VertexId>(&point->point);
      forces.shares_[i].place =
          vertex != nullptr ? mesh.rest_position(*vertex) : std::get<Eigen::Vector2d>(point->point);
      continue;
    }
    const Place place = std::visit(FindPlace{}, loads[i].kind);
    const std::string field = path + "." + place.name + ".region";
    KERF_TRY_ASSIGN(const PlacedRegion placed, scene::place(*place.region, initial.components, field));
    KERF_TRY_ASSIGN(const std::vector<VertexId> region, find_vertices(mesh, placed, field));
    if (place.is_border && schedules_cuts(*forces.config_)) continue;
    if (!(place.is_border ? edges_in(mesh, region).empty() : triangles_in(mesh, region).empty())) continue;
    const char* const what = place.is_border ? " does not contain both ends of any border edge of the sheet"
                                             : " does not contain all corners of any triangle of the sheet";
    return invalid_argument("NOTHING_LOADED", field + what, field);
  }
  forces.follow(mesh, initial);
  return forces;
}

double AppliedForces::last_change() const {
  double last = -kForever;
  for (const Load& load : config_->loads) {
    if (!load.history.times.empty()) last = std::max(last, load.history.times.back());
  }
  return last;
}

void AppliedForces::follow(const mesh::TriangleMesh& mesh, const BuiltMesh& initial) {
  for (std::size_t i = 0; i < shares_.size(); ++i) {
    Shares& shares = shares_[i];
    shares.forces.clear();
    shares.pressed.clear();
    shares.moments.clear();
    std::visit([&](const auto& load) { follow(load, mesh, initial, shares); }, config_->loads[i].kind);
  }
}

void AppliedForces::follow(const PointForce& load, const mesh::TriangleMesh& mesh, const BuiltMesh& /*initial*/,
                           Shares& shares) {
  const auto* vertex = std::get_if<VertexId>(&load.point);
  if (vertex != nullptr && *vertex < mesh.num_vertices() && mesh.has_material(*vertex)) {
    shares.forces.push_back({*vertex, load.force});
    return;
  }
  const std::optional<MaterialPoint> at = find_material_point(mesh, shares.place);
  if (!at) return;
  for (std::size_t k = 0; k < 3; ++k) {
    shares.forces.push_back({at->vertices[k], at->weights[static_cast<Eigen::Index>(k)] * load.force});
  }
}

void AppliedForces::follow(const EdgeForce& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial,
                           Shares& shares) {
  const std::vector<BorderEdge> edges = edges_in(mesh, vertices_of(mesh, load.region, initial));
  const double unit = load.is_total && !load.normal ? total_length(edges) : 1.0;
  for (const BorderEdge& edge : edges) {
    Eigen::Vector3d force = load.force;
    if (load.normal) force = *load.normal * outward_normal(mesh, edge, initial);
    for (std::size_t k = 0; k < 2; ++k) {
      double integral = 0.5 * edge.length;  // m, integral along the edge of the factor times the linear shape function
      if (load.factor) {
        const double here = load.factor->at(mesh.rest_position(edge.ends[k]));
        const double there = load.factor->at(mesh.rest_position(edge.ends[1 - k]));
        integral = (2.0 * here + there) / 6.0 * edge.length;
      }
      shares.forces.push_back({edge.ends[k], integral / unit * force});
    }
  }
}

void AppliedForces::follow(const AreaForce& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial,
                           Shares& shares) {
  const std::vector<mesh::TriangleId> triangles = triangles_in(mesh, vertices_of(mesh, load.region, initial));
  double unit = load.is_total ? 0.0 : 1.0;
  for (const mesh::TriangleId t : triangles) unit += load.is_total ? rest_area(mesh, t) : 0.0;
  for (const mesh::TriangleId t : triangles) {
    for (const VertexId v : mesh.vertices(t))
      shares.forces.push_back({v, rest_area(mesh, t) / unit / 3.0 * load.force});
  }
}

void AppliedForces::follow(const Pressure& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial,
                           Shares& shares) {
  shares.pressed = triangles_in(mesh, vertices_of(mesh, load.region, initial));
}

void AppliedForces::follow(const EdgeMoment& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial,
                           Shares& shares) {
  const std::vector<BorderEdge> edges = edges_in(mesh, vertices_of(mesh, load.region, initial));
  const double unit = load.is_total ? total_length(edges) : 1.0;
  for (const BorderEdge& edge : edges) shares.moments.push_back({edge.slot, edge.edge, load.moment / unit});
}

void AppliedForces::set(const Instant& now, const mesh::TriangleMesh& mesh, const fem::Model& model,
                        fem::Loads& loads) const {
  loads.external_forces.resize(mesh.num_vertices());
  loads.external_forces.setZero();
  loads.pressure.clear();
  loads.edge_moments.clear();
  std::map<std::pair<mesh::TriangleId, int>, double> moments;  // by slot and edge, N m per m: the sum over all loads
  for (std::size_t i = 0; i < shares_.size(); ++i) {
    const double factor = config_->loads[i].history.at(now.time, now.absent);
    for (const Share& share : shares_[i].forces) loads.external_forces.col(share.vertex) += factor * share.force;
    if (const auto* pressure = std::get_if<Pressure>(&config_->loads[i].kind)) {
      loads.pressure.resize(static_cast<std::size_t>(mesh.num_triangle_slots()), 0.0);
      for (const mesh::TriangleId t : shares_[i].pressed) {
        loads.pressure[static_cast<std::size_t>(t)] += factor * pressure->pressure;
      }
    }
    for (const EdgeShare& share : shares_[i].moments) moments[{share.slot, share.edge}] += factor * share.moment;
  }
  for (const auto& [edge, moment] : moments) {
    loads.edge_moments.push_back(model.edge_moment(mesh, edge.first, edge.second, moment));
  }
}

}  // namespace kerf::scene
