#include "server/core/mesh/refine/straight_walk.h"

#include <array>

#include <Eigen/Core>

#include "server/core/mesh/lattice_geometry.h"
#include "server/core/mesh/triangle_shape.h"

namespace kerf::mesh {
namespace {

constexpr int kMaxWalk = 512;  // most triangles on the way

bool holds(const TriangleMesh& mesh, TriangleId t, const LatticePoint& at) {
  const std::array<LatticePoint, 3> p = corners_of(mesh, t);
  return orient2d(p[0], p[1], at) >= 0 && orient2d(p[1], p[2], at) >= 0 && orient2d(p[2], p[0], at) >= 0;
}

}  // namespace

std::optional<MeshSide> find_wall(const TriangleMesh& mesh, TriangleId t, const LatticePoint& target,
                                  Location& location) {
  const std::array<LatticePoint, 3> at = corners_of(mesh, t);
  const Eigen::Vector2d to_middle = (difference(at[0], at[1]) + difference(at[0], at[2])) / 3.0;
  const LatticePoint middle = rounded(at[0], to_middle);
  int entered = kNone;  // edge by which the walk entered t
  location = Location{};
  for (int step = 0; step < kMaxWalk; ++step) {
    int exit = kNone;
    for (int k = 0; k < 3 && exit == kNone; ++k) {
      if (k == entered) continue;
      const LatticePoint& right = mesh.at(mesh.points(t)[next_corner(k)]);
      const LatticePoint& left = mesh.at(mesh.points(t)[previous_corner(k)]);
      if (orient2d(right, left, target) >= 0) continue;
      if (orient2d(middle, target, right) <= 0 && orient2d(middle, target, left) >= 0) exit = k;
    }
    if (exit == kNone) {
      if (holds(mesh, t, target)) location = mesh.locate(target, t);
      return std::nullopt;
    }
    if (mesh.is_fixed(t, exit)) return MeshSide{t, exit};
    entered = mesh.mirror_corner(t, exit);
    t = mesh.welded_neighbour(t, exit);
  }
  return std::nullopt;
}

}  // namespace kerf::mesh
