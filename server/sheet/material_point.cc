#include "server/sheet/material_point.h"

#include <algorithm>
#include <vector>

namespace kerf::sheet {

namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// The solid slot that has the location, the lowest of several; kNone in the void.
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

}  // namespace kerf::sheet
