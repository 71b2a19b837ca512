#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/fem/model/model.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// A term of a model's stiffness: a triangle of the membrane, a bending patch, or a bending term at an edge. Each is a
// symmetric matrix over a few vertices, times the 3x3 identity, with rows that sum to 0. The matrix of a triangle is z
// A g_i.g_j, which bounds its stiffness in every position (see membrane_curvature.h). The matrix of a patch is its Q.
// On a curved rest shape a bound of RestBending is added to it.
class StiffPart {
 public:
  static constexpr std::size_t kMaxVertices = 8;

  StiffPart() = default;
  static StiffPart triangle(mesh::TriangleId slot) { return StiffPart(8 * std::int64_t{slot}); }
  static StiffPart patch(mesh::TriangleId slot) { return StiffPart(8 * std::int64_t{slot} + 1); }
  static StiffPart edge(mesh::TriangleId slot, int first_edge) {
    return StiffPart(8 * std::int64_t{slot} + 2 + first_edge);
  }
  friend auto operator<=>(const StiffPart&, const StiffPart&) = default;

  [[nodiscard]] mesh::TriangleId slot() const { return static_cast<mesh::TriangleId>(key_ / 8); }
  [[nodiscard]] bool is_triangle() const { return key_ % 8 == 0; }

  // Vertices of the part, kNone in unused places; a vertex may repeat. The matrix, N/m, is indexed by these places.
  struct Matrix {
    std::array<mesh::VertexId, kMaxVertices> vertex{};
    std::array<std::array<double, kMaxVertices>, kMaxVertices> value{};
  };
  [[nodiscard]] Matrix matrix(const Model& model) const;
  // Returns only the vertices.
  [[nodiscard]] std::array<mesh::VertexId, kMaxVertices> vertices(const Model& model) const;

 private:
  explicit StiffPart(std::int64_t key) : key_(key) {}
  [[nodiscard]] int kind() const { return static_cast<int>(key_ % 8); }

  std::int64_t key_ = 0;
};

// A part that contains a vertex, and the absolute sum of its row for that vertex, N/m.
struct PartAtVertex {
  StiffPart part;
  double row_sum = 0.0;
};

// Returns the sum over the triangles at a vertex of their absolute row sums for it, N/m.
double membrane_row_sum(const Model& model, mesh::VertexId vertex);
// Returns the absolute sum of the vertex's row of BendingOperator::bound_rows(), N/m.
double bending_row_sum(const Model& model, mesh::VertexId vertex);

// Finds all triangles at a vertex, by ascending part.
void find_triangles_at(const Model& model, mesh::VertexId vertex, std::vector<PartAtVertex>& parts);
// Finds all patches and bending edges that contain a vertex, by ascending part. `slots` is scratch.
void find_bending_at(const Model& model, mesh::VertexId vertex, std::vector<mesh::TriangleId>& slots,
                     std::vector<PartAtVertex>& parts);

}  // namespace kerf::fem
