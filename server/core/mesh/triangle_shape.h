#pragma once

#include <array>
#include <numbers>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// The shape of one triangle of the rest shape. Lengths are in lattice units.
struct TriangleShape {
  int sharpest_corner = 0;    // corner of the smallest angle, opposite the shortest edge (the first of equals)
  double cos_smallest = 0.5;  // -; cosine of the smallest angle, in [1/2, 1)
  double shortest = 0.0;
  double longest = 0.0;
  double smallest_height = 0.0;
  double quality = 0.0;  // -; 4 sqrt(3) area / sum of squared edges, 1 for the equilateral triangle, 0 for a flat one
};

// Returns TriangleShape::quality from twice the area and the sum of the squared edge lengths.
inline double quality_of(double doubled_area, double squared_edges) {
  return 2.0 * std::numbers::sqrt3 * doubled_area / squared_edges;
}

TriangleShape shape_of(const std::array<LatticePoint, 3>& corners);
// Returns the shape from the squared lengths of the edges opposite each corner and twice the area.
TriangleShape shape_of(const std::array<double, 3>& squared, double doubled_area);
// Returns the shape of a solid triangle in the rest shape; if that is curved, on its surface.
TriangleShape rest_shape_of(const TriangleMesh& mesh, TriangleId t);

inline std::array<LatticePoint, 3> corners_of(const TriangleMesh& mesh, TriangleId t) {
  const auto& p = mesh.points(t);
  return {mesh.at(p[0]), mesh.at(p[1]), mesh.at(p[2])};
}

}  // namespace kerf::mesh
