#include "server/sheet/applied_forces.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "server/sheet/material_point.h"

namespace kerf::sheet {

namespace {

using mesh::VertexId;

struct Part {
  std::array<VertexId, 3> vertices{mesh::kNone, mesh::kNone, mesh::kNone};  // that share it equally
  double measure = 0.0;                                                     // m or m^2
};

bool has(const std::vector<VertexId>& sorted, VertexId v) {
  return std::binary_search(sorted.begin(), sorted.end(), v);
}

// Border edges of the opened mesh both ends of which are in the region.
std::vector<Part> edges_in(const mesh::TriangleMesh& mesh, const std::vector<VertexId>& region) {
  std::vector<Part> edges;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const std::array<VertexId, 3> corner = mesh.vertices(t);
    for (std::size_t k = 0; k < 3; ++k) {
      const VertexId a = corner[(k + 1) % 3];
      const VertexId b = corner[(k + 2) % 3];
      if (!has(region, a) || !has(region, b) || mesh.neighbour(t, static_cast<int>(k)) != mesh::kNone) continue;
      edges.push_back({{a, b, mesh::kNone}, (mesh.rest_position(a) - mesh.rest_position(b)).norm()});
    }
  }
  return edges;
}

std::vector<Part> triangles_in(const mesh::TriangleMesh& mesh, const std::vector<VertexId>& region) {
  std::vector<Part> triangles;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const std::array<VertexId, 3> corner = mesh.vertices(t);
    if (!has(region, corner[0]) || !has(region, corner[1]) || !has(region, corner[2])) continue;
    const Eigen::Vector2d a = mesh.rest_position(corner[1]) - mesh.rest_position(corner[0]);
    const Eigen::Vector2d b = mesh.rest_position(corner[2]) - mesh.rest_position(corner[0]);
    triangles.push_back({corner, 0.5 * (a.x() * b.y() - a.y() * b.x())});
  }
  return triangles;
}

// Whether lips may come to a region that has no border yet.
bool schedules_cuts(const SheetConfig& config) {
  return std::any_of(config.commands.begin(), config.commands.end(), [](const ScheduledCommand& scheduled) {
    return std::holds_alternative<Cut>(scheduled.command) || std::holds_alternative<CutBatch>(scheduled.command);
  });
}

}  // namespace

Result<AppliedForces> AppliedForces::create(std::shared_ptr<const SheetConfig> config, const mesh::TriangleMesh& mesh) {
  AppliedForces forces(std::move(config));
  const std::vector<Load>& loads = forces.config_->loads;
  forces.shares_.resize(loads.size());
  forces.places_.resize(loads.size(), Eigen::Vector2d::Zero());
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const std::string path = "loads[" + std::to_string(i) + "]";
    if (const auto* point = std::get_if<PointForce>(&loads[i].kind)) {
      if (const auto* vertex = std::get_if<VertexId>(&point->point)) {
        const std::string field = path + ".point.vertex";
        if (const auto found = find_vertices(mesh, Region(std::vector<VertexId>{*vertex}), field); !found) {
          return invalid_argument("UNKNOWN_VERTEX",
                                  field + " is " + std::to_string(*vertex) + "; the sheet has vertices 0.." +
                                      std::to_string(mesh.num_vertices() - 1),
                                  field);
        }
        forces.places_[i] = mesh.rest_position(*vertex);
      } else {
        forces.places_[i] = std::get<Eigen::Vector2d>(point->point);
        if (!find_material_point(mesh, forces.places_[i])) {
          const std::string field = path + ".point.material";
          return invalid_argument("POINT_OUTSIDE", field + " is not a point of the sheet", field);
        }
      }
      continue;
    }
    const auto* edge = std::get_if<EdgeForce>(&loads[i].kind);
    const auto* area = std::get_if<AreaForce>(&loads[i].kind);
    const std::string field = path + (edge != nullptr ? ".edge.region" : ".area.region");
    const Result<std::vector<VertexId>> region =
        find_vertices(mesh, edge != nullptr ? edge->region : area->region, field);
    if (!region) return region.error();
    if (edge != nullptr && schedules_cuts(*forces.config_)) continue;
    if (edge != nullptr ? edges_in(mesh, *region).empty() : triangles_in(mesh, *region).empty()) {
      return invalid_argument(
          "NOTHING_LOADED",
          field + (edge != nullptr ? " has no border edge of the sheet, both ends of which are in it"
                                   : " has no triangle of the sheet, all corners of which are in it"),
          field);
    }
  }
  forces.follow(mesh);
  return forces;
}

double AppliedForces::last_change() const {
  double last = -kForever;
  for (const Load& load : config_->loads) {
    if (!load.history.times.empty()) last = std::max(last, load.history.times.back());
  }
  return last;
}

void AppliedForces::follow(const mesh::TriangleMesh& mesh) {
  for (std::size_t i = 0; i < shares_.size(); ++i) {
    const Load& load = config_->loads[i];
    std::vector<Share>& shares = shares_[i];
    shares.clear();
    if (const auto* point = std::get_if<PointForce>(&load.kind)) {
      const auto* vertex = std::get_if<VertexId>(&point->point);
      if (vertex != nullptr && *vertex < mesh.num_vertices() && mesh.has_material(*vertex)) {
        shares.push_back({*vertex, point->force});
      } else if (const std::optional<MaterialPoint> at = find_material_point(mesh, places_[i])) {
        for (std::size_t k = 0; k < 3; ++k) {
          shares.push_back({at->vertices[k], at->weights[static_cast<Eigen::Index>(k)] * point->force});
        }
      }
      continue;
    }
    const auto* edge = std::get_if<EdgeForce>(&load.kind);
    const auto* area = std::get_if<AreaForce>(&load.kind);
    Region region = edge != nullptr ? edge->region : area->region;
    if (auto* listed = std::get_if<std::vector<VertexId>>(&region)) {
      std::erase_if(*listed, [&](VertexId v) { return v >= mesh.num_vertices() || !mesh.has_material(v); });
    }
    const std::vector<VertexId> found = find_vertices(mesh, region, "").value();
    const std::vector<Part> parts = edge != nullptr ? edges_in(mesh, found) : triangles_in(mesh, found);
    double whole = 0.0;
    for (const Part& part : parts) whole += part.measure;
    const bool is_total = edge != nullptr ? edge->is_total : area->is_total;
    const Eigen::Vector3d force = edge != nullptr ? edge->force : area->force;
    const double corners = edge != nullptr ? 2.0 : 3.0;
    for (const Part& part : parts) {
      const double measure = is_total ? part.measure / whole : part.measure;
      for (const VertexId v : part.vertices) {
        if (v != mesh::kNone) shares.push_back({v, measure / corners * force});
      }
    }
  }
}

void AppliedForces::set(const Instant& now, const mesh::TriangleMesh& mesh, mesh::VertexField& forces) const {
  forces.resize(mesh.num_vertices());
  forces.setZero();
  for (std::size_t i = 0; i < shares_.size(); ++i) {
    const double factor = config_->loads[i].history.at(now.time, now.absent);
    for (const Share& share : shares_[i]) forces.col(share.vertex) += factor * share.force;
  }
}

}  // namespace kerf::sheet
