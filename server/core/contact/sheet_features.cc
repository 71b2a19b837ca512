#include "server/core/contact/sheet_features.h"

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace kerf::contact {

using mesh::kNone;
using mesh::TriangleId;
using mesh::VertexId;

void SheetFeatures::set(const mesh::TriangleMesh& mesh, std::span<const TriangleId> order) {
  const auto num_vertices = static_cast<std::size_t>(mesh.num_vertices());
  triangles.clear();
  edges.clear();
  vertices.clear();
  first_edge.clear();
  first_vertex.clear();
  borders.clear();
  first_border.clear();
  material.resize(num_vertices);
  altitude_at.assign(num_vertices, std::numeric_limits<double>::infinity());
  std::vector<std::int32_t> place(static_cast<std::size_t>(mesh.num_triangle_slots()), kNone);
  for (std::size_t k = 0; k < order.size(); ++k)
    place[static_cast<std::size_t>(order[k])] = static_cast<std::int32_t>(k);
  std::vector<std::uint8_t> is_owned(num_vertices, 0);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const TriangleId t = order[i];
    Triangle triangle;
    triangle.vertices = mesh.vertices(t);
    first_edge.push_back(static_cast<std::int32_t>(edges.size()));
    first_vertex.push_back(static_cast<std::int32_t>(vertices.size()));
    first_border.push_back(static_cast<std::int32_t>(borders.size()));
    for (int k = 0; k < 3; ++k) {
      const TriangleId other = mesh.neighbour(t, k);
      const auto corner = static_cast<std::size_t>(k);
      const std::array<VertexId, 2> ends{triangle.vertices[(corner + 1) % 3], triangle.vertices[(corner + 2) % 3]};
      triangle.across[corner] =
          other == kNone ? kNone : mesh.vertices(other)[static_cast<std::size_t>(mesh.mirror_corner(t, k))];
      if (other == kNone) borders.push_back(ends);
      if (other == kNone || place[static_cast<std::size_t>(other)] > static_cast<std::int32_t>(i)) {
        triangle.owns_edge[corner] = true;
        edges.push_back({ends});
      }
    }
    for (const VertexId v : triangle.vertices) {
      std::uint8_t& owned = is_owned[static_cast<std::size_t>(v)];
      if (owned != 0) continue;
      owned = 1;
      vertices.push_back(v);
      material[static_cast<std::size_t>(v)] = mesh.rest_position(v);
    }
    const Eigen::Vector2d& at = material[static_cast<std::size_t>(triangle.vertices[0])];
    Eigen::Matrix2d sides;
    sides.col(0) = material[static_cast<std::size_t>(triangle.vertices[1])] - at;
    sides.col(1) = material[static_cast<std::size_t>(triangle.vertices[2])] - at;
    triangle.inverse_edges = sides.inverse();
    const double longest = std::max({sides.col(0).norm(), sides.col(1).norm(), (sides.col(1) - sides.col(0)).norm()});
    triangle.altitude = std::abs(sides.determinant()) / longest;
    for (const VertexId v : triangle.vertices) {
      double& least = altitude_at[static_cast<std::size_t>(v)];
      least = std::min(least, triangle.altitude);
    }
    triangles.push_back(triangle);
  }
  first_edge.push_back(static_cast<std::int32_t>(edges.size()));
  first_vertex.push_back(static_cast<std::int32_t>(vertices.size()));
  first_border.push_back(static_cast<std::int32_t>(borders.size()));

  set_neighbours(num_vertices);
}

void SheetFeatures::set_neighbours(std::size_t num_vertices) {
  first_neighbour.assign(num_vertices + 1, 0);
  first_triangle_at.assign(num_vertices + 1, 0);
  for (const Edge& edge : edges) {
    for (const VertexId v : edge.vertices) ++first_neighbour[static_cast<std::size_t>(v) + 1];
  }
  for (const Triangle& triangle : triangles) {
    for (const VertexId v : triangle.vertices) ++first_triangle_at[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t v = 0; v < num_vertices; ++v) {
    first_neighbour[v + 1] += first_neighbour[v];
    first_triangle_at[v + 1] += first_triangle_at[v];
  }
  neighbours.resize(2 * edges.size());
  edges_at.resize(2 * edges.size());
  triangles_at.resize(3 * triangles.size());
  std::vector<std::int32_t> next(first_neighbour.begin(), first_neighbour.end() - 1);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    for (std::size_t k = 0; k < 2; ++k) {
      const auto place = static_cast<std::size_t>(next[static_cast<std::size_t>(edges[e].vertices[k])]++);
      neighbours[place] = edges[e].vertices[1 - k];
      edges_at[place] = static_cast<std::int32_t>(e);
    }
  }
  next.assign(first_triangle_at.begin(), first_triangle_at.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const VertexId v : triangles[t].vertices) {
      triangles_at[static_cast<std::size_t>(next[static_cast<std::size_t>(v)]++)] = static_cast<std::int32_t>(t);
    }
  }
}

}  // namespace kerf::contact
