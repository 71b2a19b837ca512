#pragma once

#include <array>
#include <numbers>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// The shape of one triangle in rest space. Lengths in lattice units.
struct TriangleShape {
  int sharpest_corner = 0;    // corner of the smallest angle, opposite the shortest edge (the first of equals)
  double cos_smallest = 0.5;  // -; cosine of the smallest angle, in [1/2, 1)
  double shortest = 0.0;
  double longest = 0.0;
  double smallest_height = 0.0;
  double quality = 0.0;  // -; 4 sqrt(3) area / sum of squared edges, 1 for the equilateral triangle, 0 for a flat one
};

// The quality of a triangle by twice its area and the sum of the squared lengths of its edges.
inline double quality_of(double doubled_area, double squared_edges) {
  return 2.0 * std::numbers::sqrt3 * doubled_area / squared_edges;
}

TriangleShape shape_of(const std::array<LatticePoint, 3>& corners);
// From the squared lengths of the edges opposite each corner.
TriangleShape shape_of(const std::array<double, 3>& squared, double doubled_area);
// Returns the shape of a solid triangle in the rest shape: on the surface if that is curved.
TriangleShape rest_shape_of(const TriangleMesh& mesh, TriangleId t);

inline std::array<LatticePoint, 3> corners_of(const TriangleMesh& mesh, TriangleId t) {
  const auto& p = mesh.points(t);
  return {mesh.at(p[0]), mesh.at(p[1]), mesh.at(p[2])};
}

}  // namespace kerf::mesh
