#include "server/core/mesh/triangle_shape.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "server/core/mesh/lattice_geometry.h"

namespace kerf::mesh {

TriangleShape shape_of(const std::array<LatticePoint, 3>& corners) {
  std::array<double, 3> squared{};  // squared length of the edge opposite each corner
  for (int k = 0; k < 3; ++k) {
    squared[k] = squared_distance(corners[next_corner(k)], corners[previous_corner(k)]);
  }
  return shape_of(squared, to_double(doubled_area(corners[0], corners[1], corners[2])));
}

TriangleShape rest_shape_of(const TriangleMesh& mesh, TriangleId t) {
  if (!mesh.is_curved()) return shape_of(corners_of(mesh, t));
  const Eigen::Matrix2d edges = mesh.rest_edges(t) / mesh.lattice().spacing;
  const std::array<double, 3> squared{(edges.col(1) - edges.col(0)).squaredNorm(), edges.col(1).squaredNorm(),
                                      edges.col(0).squaredNorm()};
  return shape_of(squared, edges.determinant());
}

TriangleShape shape_of(const std::array<double, 3>& squared, double doubled_area) {
  TriangleShape shape;
  shape.sharpest_corner = static_cast<int>(std::min_element(squared.begin(), squared.end()) - squared.begin());
  const double a = squared[shape.sharpest_corner];
  const double b = squared[next_corner(shape.sharpest_corner)];
  const double c = squared[previous_corner(shape.sharpest_corner)];
  shape.cos_smallest = (b + c - a) / (2.0 * std::sqrt(b * c));
  shape.shortest = std::sqrt(a);
  shape.longest = std::sqrt(std::max(b, c));
  shape.smallest_height = doubled_area / shape.longest;
  shape.quality = quality_of(doubled_area, a + b + c);
  return shape;
}

}  // namespace kerf::mesh
