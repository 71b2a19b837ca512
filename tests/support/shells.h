#pragma once

// Makes sheets with curved rest shapes.

#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Core>

#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "tests/support/meshes.h"

namespace kerf::test {

// Returns the unit square with num x num vertices, jittered or not. `map` gives the rest position in space of each
// vertex.
template <typename Map>
mesh::IndexedMesh shell(std::int32_t num, bool jittered, const Map& map) {
  const mesh::TriangleMesh flat = jittered ? jittered_grid(num, 7) : grid(num);
  mesh::IndexedMesh sheet;
  sheet.rest.resize(2, flat.num_vertices());
  sheet.surface.resize(3, flat.num_vertices());
  for (mesh::VertexId v = 0; v < flat.num_vertices(); ++v) {
    sheet.rest.col(v) = flat.rest_position(v);
    sheet.surface.col(v) = map(flat.rest_position(v));
  }
  sheet.triangles.resize(3, flat.num_solid_triangles());
  for (mesh::TriangleId t = 0; t < flat.num_solid_triangles(); ++t) {
    sheet.triangles.col(t) = Eigen::Vector3i(flat.vertices(t)[0], flat.vertices(t)[1], flat.vertices(t)[2]);
  }
  return sheet;
}

// Returns a square rolled about an axis along y, with this radius (m). Lengths stay, except that chords replace arcs.
inline mesh::IndexedMesh rolled_square(std::int32_t num, double radius, bool jittered = false) {
  return shell(num, jittered, [radius](const Eigen::Vector2d& at) {
    const double angle = (at.x() - 0.5) / radius;
    return Eigen::Vector3d(radius * std::sin(angle), at.y(), radius * (std::cos(angle) - 1.0));
  });
}

// Returns the upper part of a sphere of radius 1 m over a square of side `side` <= 1.2 m.
inline mesh::IndexedMesh dome(std::int32_t num, double side, bool jittered = false) {
  return shell(num, jittered, [side](const Eigen::Vector2d& at) {
    const Eigen::Vector2d p = side * (at - Eigen::Vector2d(0.5, 0.5));
    return Eigen::Vector3d(p.x(), p.y(), std::sqrt(1.0 - p.squaredNorm()));
  });
}

// Returns two rectangles of 1 m that meet at a right angle along y.
inline mesh::IndexedMesh creased_sheet(std::int32_t num) {
  return shell(num, false, [](const Eigen::Vector2d& at) {
    const double x = 2.0 * (at.x() - 0.5);
    return x < 0.0 ? Eigen::Vector3d(x, at.y(), 0.0) : Eigen::Vector3d(0.0, at.y(), x);
  });
}

}  // namespace kerf::test
