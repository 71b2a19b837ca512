#pragma once

#include <array>

#include "server/mesh/triangle_mesh.h"

namespace kerf::cut {

// The shape of one triangle in rest space. Lengths in lattice units.
struct TriangleShape {
  int sharpest_corner = 0;    // corner of the smallest angle, opposite the shortest edge (the first of equals)
  double cos_smallest = 0.5;  // -; cosine of the smallest angle, in [1/2, 1)
  double shortest = 0.0;
  double longest = 0.0;
  double smallest_height = 0.0;
  double quality = 0.0;  // -; 4 sqrt(3) area / sum of squared edges, 1 for the equilateral triangle, 0 for a flat one
};

TriangleShape shape_of(const std::array<mesh::LatticePoint, 3>& corners);

inline std::array<mesh::LatticePoint, 3> corners_of(const mesh::TriangleMesh& mesh, mesh::TriangleId t) {
  const auto& p = mesh.points(t);
  return {mesh.at(p[0]), mesh.at(p[1]), mesh.at(p[2])};
}

}  // namespace kerf::cut
