#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::contact {

// Vertices, edges and triangles of an opened mesh as self-contact needs them, in the order of FeatureTree. Each vertex
// and each edge is owned by one triangle.
struct SheetFeatures {
  struct Triangle {
    std::array<mesh::VertexId, 3> vertices{};
    // The third vertex of the triangle across the edge opposite corner k; kNone at a border.
    std::array<mesh::VertexId, 3> across{};
    Eigen::Matrix2d inverse_edges = Eigen::Matrix2d::Zero();  // 1/m, inverse of the material edges from corner 0
    std::array<bool, 3> owns_edge{};                          // the edge opposite corner k
    double altitude = 0.0;                                    // m, least altitude in material space
  };
  struct Edge {
    std::array<mesh::VertexId, 2> vertices{};
  };

  std::vector<Triangle> triangles;
  std::vector<Edge> edges;
  std::vector<mesh::VertexId> vertices;                // those with material
  std::vector<std::int32_t> first_edge;                // by triangle, and one more: edges that it owns
  std::vector<std::int32_t> first_vertex;              // the same for `vertices`
  std::vector<std::int32_t> first_border;              // the same for `borders`
  std::vector<double> altitude_at;                     // m, by vertex id: least altitude of its triangles
  std::vector<Eigen::Vector2d> material;               // m, by vertex id
  std::vector<std::int32_t> first_neighbour;           // by vertex id, and one more
  std::vector<mesh::VertexId> neighbours;              // vertices that an edge joins to a vertex
  std::vector<std::int32_t> edges_at;                  // these edges, in the order of `neighbours`
  std::vector<std::int32_t> first_triangle_at;         // by vertex id, and one more
  std::vector<std::int32_t> triangles_at;              // triangles with a corner at a vertex
  std::vector<std::array<mesh::VertexId, 2>> borders;  // edges of one triangle: borders and lips

  // Lists the features of a mesh. `order`: its solid triangles, each once.
  void set(const mesh::TriangleMesh& mesh, std::span<const mesh::TriangleId> order);
  [[nodiscard]] std::span<const mesh::VertexId> neighbours_of(mesh::VertexId v) const {
    return part(std::span(neighbours), first_neighbour, v);
  }
  [[nodiscard]] std::span<const std::int32_t> edges_of(mesh::VertexId v) const {
    return part(std::span(edges_at), first_neighbour, v);
  }
  [[nodiscard]] std::span<const std::int32_t> triangles_of(mesh::VertexId v) const {
    return part(std::span(triangles_at), first_triangle_at, v);
  }

 private:
  void set_neighbours(std::size_t num_vertices);
  template <typename T>
  static std::span<T> part(std::span<T> all, const std::vector<std::int32_t>& first, mesh::VertexId v) {
    const auto i = static_cast<std::size_t>(v);
    return all.subspan(static_cast<std::size_t>(first[i]), static_cast<std::size_t>(first[i + 1] - first[i]));
  }
};

}  // namespace kerf::contact
