#include "server/core/cut/bent_edges.h"

#include <algorithm>
#include <cstddef>

#include <Eigen/Geometry>

#include "server/core/cut/crossed_triangles.h"
#include "server/core/mesh/id_map.h"
#include "server/core/mesh/lattice_geometry.h"

namespace kerf::cut {
namespace {

using mesh::next_corner;
using mesh::PointId;
using mesh::previous_corner;
using mesh::TriangleId;

constexpr int kRings = 3;       // rings of triangles around those crossed that refinement may reach, at least
constexpr double kReach = 2.5;  // edge lengths around those crossed that it may reach, however small triangles are

// Returns the triangles that the strokes run through, with those around them; solid ones only.
mesh::IdMap neighbourhood(const mesh::TriangleMesh& mesh, std::span<const Stroke> strokes) {
  mesh::IdMap found;
  std::vector<PointId> origins;  // a corner of the triangle crossed from which each was found
  for (const TriangleId t : crossed_triangles(mesh, strokes)) {
    found.add(t);
    origins.push_back(mesh.points(t)[0]);
  }
  const double reach = kReach * mesh.base_edge_length() / mesh.lattice().spacing;
  std::vector<TriangleId> fan;
  std::size_t begin = 0;
  for (int ring = 0; begin < found.ids().size(); ++ring) {
    const std::size_t end = found.ids().size();
    for (std::size_t i = begin; i < end; ++i) {
      const std::array<PointId, 3> corners = mesh.points(found.ids()[i]);
      for (const PointId p : corners) {
        if (ring >= kRings && difference(mesh.at(origins[i]), mesh.at(p)).norm() > reach) continue;
        mesh.fan_around(p, fan);
        for (const TriangleId t : fan) {
          if (mesh.is_solid(t) && found.add(t)) origins.push_back(origins[i]);
        }
      }
    }
    begin = end;
  }
  return found;
}

// Returns how far a flip of edge k of t moves the sheet, m: the distance in space of the two diagonals of the
// quadrilateral at the edge, where they cross in the material plane. Not finite where they are parallel there.
double shift_of_flip(const mesh::TriangleMesh& mesh, TriangleId t, int k, const linear::VertexField& positions) {
  const TriangleId beside = mesh.welded_neighbour(t, k);
  const int corner = mesh.mirror_corner(t, k);
  const mesh::LatticePoint& a = mesh.at(mesh.points(t)[next_corner(k)]);
  const mesh::LatticePoint& c = mesh.at(mesh.points(t)[k]);
  const Eigen::Vector2d edge = difference(a, mesh.at(mesh.points(t)[previous_corner(k)]));
  const Eigen::Vector2d other = difference(c, mesh.at(mesh.points(beside)[corner]));
  const Eigen::Vector2d between = difference(a, c);
  const auto cross = [](const Eigen::Vector2d& u, const Eigen::Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); };
  const double turn = cross(edge, other);
  const double along_edge = cross(between, other) / turn;
  const double along_other = cross(between, edge) / turn;
  const auto at = [&](TriangleId triangle, int which) { return positions.col(mesh.vertices(triangle)[which]); };
  const Eigen::Vector3d on_edge = (1.0 - along_edge) * at(t, next_corner(k)) + along_edge * at(t, previous_corner(k));
  const Eigen::Vector3d on_other = (1.0 - along_other) * at(t, k) + along_other * at(beside, corner);
  return (on_edge - on_other).norm();
}

}  // namespace

std::vector<std::array<PointId, 2>> bent_edges(const mesh::TriangleMesh& mesh, std::span<const Stroke> strokes,
                                               const linear::VertexField& positions, const ShiftLimit& limit) {
  std::vector<std::array<PointId, 2>> edges;
  const auto is_apart = [&](TriangleId t) {
    return std::ranges::all_of(mesh.vertices(t), [&](mesh::VertexId v) {
      const auto i = static_cast<std::size_t>(v);
      return i < limit.is_apart.size() && limit.is_apart[i] != 0;
    });
  };
  const mesh::IdMap near = neighbourhood(mesh, strokes);
  for (const TriangleId t : near.ids()) {
    for (int k = 0; k < 3; ++k) {
      if (mesh.is_fixed(t, k)) continue;
      const TriangleId beside = mesh.welded_neighbour(t, k);
      const bool is_second_visit = beside < t && near.has(beside);
      if (is_second_visit) continue;
      const double shift = shift_of_flip(mesh, t, k, positions);
      if (shift <= limit.near || (shift <= limit.apart && is_apart(t) && is_apart(beside))) continue;
      edges.push_back({mesh.points(t)[next_corner(k)], mesh.points(t)[previous_corner(k)]});
    }
  }
  return edges;
}

}  // namespace kerf::cut
