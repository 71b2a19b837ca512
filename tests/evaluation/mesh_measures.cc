#include "tests/evaluation/mesh_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace kerf::evaluation {
namespace {

Spread spread_of(const std::vector<double>& values, bool is_worst_largest) {
  Spread spread;
  if (values.empty()) return spread;
  for (const double value : values) spread.mean += value / static_cast<double>(values.size());
  for (const double value : values) {
    spread.deviation += (value - spread.mean) * (value - spread.mean) / static_cast<double>(values.size());
  }
  spread.deviation = std::sqrt(spread.deviation);
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  spread.worst = is_worst_largest ? *largest : *least;
  return spread;
}

}  // namespace

Shapes measure_shapes(const mesh::TriangleMesh& mesh, const std::vector<mesh::TriangleId>& triangles,
                      double element_area) {
  std::vector<double> ratios, aspects, angles, areas;
  int slivers = 0;
  for (const mesh::TriangleId t : triangles) {
    std::array<double, 3> edges{};
    for (int k = 0; k < 3; ++k) {
      edges[static_cast<std::size_t>(k)] = (mesh.point_position(mesh.points(t)[mesh::next_corner(k)]) -
                                            mesh.point_position(mesh.points(t)[mesh::previous_corner(k)]))
                                               .norm();
    }
    std::sort(edges.begin(), edges.end());
    const double area = mesh.area(t);
    ratios.push_back(edges[2] / edges[0]);
    aspects.push_back(edges[2] * edges[2] / (2.0 * area));
    angles.push_back(std::asin(std::min(1.0, 2.0 * area / (edges[1] * edges[2]))) * 180.0 / std::numbers::pi);
    areas.push_back(area / element_area);
    slivers += areas.back() < 0.03 ? 1 : 0;
  }
  Shapes shapes;
  shapes.triangles = static_cast<int>(triangles.size());
  shapes.edge_ratio = spread_of(ratios, true);
  shapes.aspect = spread_of(aspects, true);
  shapes.angle = spread_of(angles, false);
  shapes.area_ratio = spread_of(areas, false);
  shapes.share_of_slivers = triangles.empty() ? 0.0 : slivers / static_cast<double>(triangles.size());
  return shapes;
}

std::vector<mesh::TriangleId> new_triangles(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after) {
  std::vector<mesh::TriangleId> made;
  for (const mesh::TriangleId t : all_triangles(after)) {
    bool is_old = t < before.num_triangle_slots() && before.points(t) == after.points(t);
    for (int k = 0; k < 3 && is_old; ++k) is_old = before.at(before.points(t)[k]) == after.at(after.points(t)[k]);
    if (!is_old) made.push_back(t);
  }
  return made;
}

std::vector<mesh::TriangleId> all_triangles(const mesh::TriangleMesh& mesh) {
  std::vector<mesh::TriangleId> all;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) all.push_back(t);
  }
  return all;
}

}  // namespace kerf::evaluation
