#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/fem/model/model.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// A term of a model's stiffness: a triangle of the membrane, a bending patch, or what bending has at an edge. Each is a
// symmetric matrix over a few vertices, times the 3x3 identity, with rows that sum to 0; that of a triangle is
// z A g_i.g_j, which bounds its stiffness in every position (see membrane_curvature.h); that of a patch is its own, and
// on a curved rest shape a bound of what RestBending adds besides.
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

  // Its vertices, kNone in places that it does not use; a vertex may repeat. Its matrix, N/m, by these places.
  struct Matrix {
    std::array<mesh::VertexId, kMaxVertices> vertex{};
    std::array<std::array<double, kMaxVertices>, kMaxVertices> value{};
  };
  [[nodiscard]] Matrix matrix(const Model& model) const;
  // Its vertices alone.
  [[nodiscard]] std::array<mesh::VertexId, kMaxVertices> vertices(const Model& model) const;

 private:
  explicit StiffPart(std::int64_t key) : key_(key) {}
  [[nodiscard]] int kind() const { return static_cast<int>(key_ % 8); }

  std::int64_t key_ = 0;
};

// A part at a vertex, and the sum of the absolute values of its row there, N/m.
struct PartAtVertex {
  StiffPart part;
  double row_sum = 0.0;
};

// N/m, the sum over the triangles at a vertex.
double membrane_row_sum(const Model& model, mesh::VertexId vertex);
// N/m, of the bending matrix, or of its bound on a curved rest shape.
double bending_row_sum(const Model& model, mesh::VertexId vertex);

// All parts at a vertex, ascending.
void find_triangles_at(const Model& model, mesh::VertexId vertex, std::vector<PartAtVertex>& parts);
// All patches and edges at a vertex, ascending. `slots` is scratch.
void find_bending_at(const Model& model, mesh::VertexId vertex, std::vector<mesh::TriangleId>& slots,
                     std::vector<PartAtVertex>& parts);

}  // namespace kerf::fem
