#include "server/core/scene/material_point.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace kerf::scene {

namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Returns the lowest solid slot at the location; kNone in the void.
mesh::TriangleId solid_triangle(const mesh::TriangleMesh& mesh, const mesh::Location& location) {
  using Kind = mesh::Location::Kind;
  std::vector<mesh::TriangleId> candidates;
  if (location.kind == Kind::kFace) candidates = {location.triangle};
  if (location.kind == Kind::kEdge) {
    candidates = {location.triangle, mesh.welded_neighbour(location.triangle, location.corner)};
  }
  if (location.kind == Kind::kPoint) mesh.fan_around(location.point, candidates);
  mesh::TriangleId lowest = mesh::kNone;
  for (const mesh::TriangleId t : candidates) {
    if (t == mesh::kNone || !mesh.is_solid(t)) continue;
    if (lowest == mesh::kNone || t < lowest) lowest = t;
  }
  return lowest;
}

// Returns the point of edge k of t that is nearest to `at`.
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

}  // namespace

std::optional<MaterialPoint> find_material_point(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& at) {
  if (!mesh.lattice().contains(at)) return std::nullopt;
  const mesh::TriangleId t = solid_triangle(mesh, mesh.locate(mesh.lattice().nearest(at)));
  if (t == mesh::kNone) return std::nullopt;
  MaterialPoint found;
  found.vertices = mesh.vertices(t);
  const Eigen::Vector2d a = mesh.rest_position(found.vertices[0]) - at;
  const Eigen::Vector2d b = mesh.rest_position(found.vertices[1]) - at;
  const Eigen::Vector2d c = mesh.rest_position(found.vertices[2]) - at;
  // Twice the areas opposite the corners; rounding may leave a tiny negative one.
  const Eigen::Vector3d areas(std::max(cross(b, c), 0.0), std::max(cross(c, a), 0.0), std::max(cross(a, b), 0.0));
  found.weights = areas / areas.sum();
  return found;
}

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
      if (!(distance < least)) continue;  // also false for NaN: the ends of a tiny edge may round to one position
      least = distance;
      nearest = point;
    }
  }
  return nearest;
}

}  // namespace kerf::scene
