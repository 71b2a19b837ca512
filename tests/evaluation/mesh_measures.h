#pragma once

#include <vector>

#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

// Measures of meshes after cuts, as section 3.2.2 of the thesis defines them.
namespace kerf::evaluation {

struct Spread {
  double mean = 0.0, deviation = 0.0, worst = 0.0;
};

struct Shapes {
  int triangles = 0;
  Spread edge_ratio;              // -, longest / shortest edge (its equation 3.10); worst: the largest
  Spread aspect;                  // -, longest edge / height on it (its other definition); worst: the largest
  Spread angle;                   // degrees, smallest angle; worst: the least
  Spread area_ratio;              // -, area over that of an element of the uncut sheet; worst: the least
  double share_of_slivers = 0.0;  // -, part of them below 3 % of the area of an element
};

// Measures triangles. `element_area`: m^2, of an element of the uncut sheet.
Shapes measure_shapes(const mesh::TriangleMesh& mesh, const std::vector<mesh::TriangleId>& triangles,
                      double element_area);

// Solid triangles that `before` does not have.
std::vector<mesh::TriangleId> new_triangles(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after);
std::vector<mesh::TriangleId> all_triangles(const mesh::TriangleMesh& mesh);

}  // namespace kerf::evaluation
