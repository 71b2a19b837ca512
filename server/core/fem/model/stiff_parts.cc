#include "server/core/fem/model/stiff_parts.h"

#include <algorithm>
#include <cmath>

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

struct Triangle {
  std::array<VertexId, 3> vertex{};
  std::array<std::array<double, 2>, 3> g{};  // 1/m, shape gradients, material axes
  double weight = 0.0;                       // N, z A
};

Triangle triangle_at(const Model& model, TriangleId slot) {
  const ElementBlock& block = model.element_blocks()[static_cast<std::size_t>(slot / kLanes)];
  const auto l = static_cast<std::size_t>(slot % kLanes);
  Triangle triangle;
  for (std::size_t k = 0; k < 3; ++k) triangle.vertex[k] = block.vertex[k][l];
  for (std::size_t c = 0; c < 2; ++c) {
    triangle.g[0][c] = -block.g1[c][l] - block.g2[c][l];
    triangle.g[1][c] = block.g1[c][l];
    triangle.g[2][c] = block.g2[c][l];
  }
  triangle.weight = model.materials().of(block, l).curvature_bound * block.area[l];
  return triangle;
}

double entry(const Triangle& triangle, std::size_t a, std::size_t b) {
  return triangle.weight * (triangle.g[a][0] * triangle.g[b][0] + triangle.g[a][1] * triangle.g[b][1]);
}

double row_sum(const Triangle& triangle, VertexId vertex) {
  double sum = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    if (triangle.vertex[a] != vertex) continue;
    for (std::size_t b = 0; b < 3; ++b) sum += std::abs(entry(triangle, a, b));
  }
  return sum;
}

// Returns the norm (N/m) of the stiffness that a curved rest shape adds to a patch.
double excess_at(const Model& model, TriangleId slot, std::size_t a, std::size_t b) {
  const std::span<const RestBending> rest = model.bending().rest(model.element_blocks()).rest;
  return rest.empty() ? 0.0 : rest[static_cast<std::size_t>(slot)].excess_at(static_cast<int>(a), static_cast<int>(b));
}

// Bounds the stiffness B that a curved rest shape adds to a patch by a matrix with rows that sum to 0. B does not act
// on a common motion. Hence, with u_a = v_a - mean(v) and r_a = sum_b |B_ab|:
//   v.B v = u.B u <= sum_ab |B_ab| |u_a| |u_b| <= sum_a r_a |u_a|^2.
class CurvatureBound {
 public:
  CurvatureBound(const Model& model, TriangleId slot) {
    const std::array<VertexId, 6>& vertex =
        model.bending().terms(model.element_blocks()).patches[static_cast<std::size_t>(slot)].vertex;
    for (std::size_t a = 0; a < 6; ++a) {
      if (vertex[a] == mesh::kNone) continue;
      ++num_;
      for (std::size_t b = 0; b < 6; ++b) row_[a] += vertex[b] == mesh::kNone ? 0.0 : excess_at(model, slot, a, b);
      sum_ += row_[a];
    }
  }
  // N/m.
  [[nodiscard]] double at(std::size_t a, std::size_t b) const {
    return (a == b ? row_[a] : 0.0) - (row_[a] + row_[b]) / num_ + sum_ / (num_ * num_);
  }

 private:
  std::array<double, 6> row_{};
  double sum_ = 0.0;
  double num_ = 0.0;
};

// Returns the absolute row sum of a part with these vertices; entry(a, b) gives its entries. Negative if the part does
// not contain the vertex.
template <std::size_t N, typename Entry>
double row_sum_of(const std::array<VertexId, N>& vertices, VertexId vertex, const Entry& entry) {
  double sum = 0.0;
  bool is_found = false;
  for (std::size_t a = 0; a < N; ++a) {
    if (vertices[a] != vertex) continue;
    is_found = true;
    for (std::size_t b = 0; b < N; ++b) sum += vertices[b] == mesh::kNone ? 0.0 : std::abs(entry(a, b));
  }
  return is_found ? sum : -1.0;
}

}  // namespace

std::array<VertexId, StiffPart::kMaxVertices> StiffPart::vertices(const Model& model) const {
  std::array<VertexId, kMaxVertices> made;
  made.fill(mesh::kNone);
  const TriangleId at = slot();
  if (is_triangle()) {
    const std::array<VertexId, 3> corners = triangle_at(model, at).vertex;
    std::copy(corners.begin(), corners.end(), made.begin());
  } else if (kind() == 1) {
    const BendingPatch& patch = model.bending().terms(model.element_blocks()).patches[static_cast<std::size_t>(at)];
    std::copy(patch.vertex.begin(), patch.vertex.end(), made.begin());
  } else {
    for (const BendingEdge& edge : model.bending().edges().row(at)) {
      if (edge.first_edge == kind() - 2) made = edge.vertex;
    }
  }
  return made;
}

StiffPart::Matrix StiffPart::matrix(const Model& model) const {
  Matrix made;
  made.vertex = vertices(model);
  const TriangleId at = slot();
  const auto fill = [&made](std::size_t size, const auto& entry) {
    for (std::size_t a = 0; a < size; ++a) {
      for (std::size_t b = 0; b < size; ++b) {
        if (made.vertex[a] != mesh::kNone && made.vertex[b] != mesh::kNone) made.value[a][b] = entry(a, b);
      }
    }
  };
  if (is_triangle()) {
    const Triangle triangle = triangle_at(model, at);
    fill(3, [&](std::size_t a, std::size_t b) { return entry(triangle, a, b); });
  } else if (kind() == 1) {
    const BendingPatch& patch = model.bending().terms(model.element_blocks()).patches[static_cast<std::size_t>(at)];
    const CurvatureBound bound(model, at);
    fill(6, [&](std::size_t a, std::size_t b) {
      return patch.at(static_cast<int>(a), static_cast<int>(b)) + bound.at(a, b);
    });
  } else {
    for (const BendingEdge& edge : model.bending().edges().row(at)) {
      if (edge.first_edge == kind() - 2) fill(8, [&](std::size_t a, std::size_t b) { return edge.at(a, b); });
    }
  }
  return made;
}

double membrane_row_sum(const Model& model, VertexId vertex) {
  double sum = 0.0;
  for (const TriangleId slot : model.elements().incident_slots().row(vertex))
    sum += row_sum(triangle_at(model, slot), vertex);
  return sum;
}

double bending_row_sum(const Model& model, VertexId vertex) {
  if (!model.materials().has_bending()) return 0.0;
  double sum = 0.0;
  for (const BendingEntry& entry : model.bending().bound_rows().row(vertex)) sum += std::abs(entry.value);
  return sum;
}

void find_triangles_at(const Model& model, VertexId vertex, std::vector<PartAtVertex>& parts) {
  parts.clear();
  for (const TriangleId slot : model.elements().incident_slots().row(vertex)) {
    parts.push_back({StiffPart::triangle(slot), row_sum(triangle_at(model, slot), vertex)});
  }
}

void find_bending_at(const Model& model, VertexId vertex, std::vector<TriangleId>& slots,
                     std::vector<PartAtVertex>& parts) {
  parts.clear();
  if (!model.materials().has_bending()) return;
  // A patch containing the vertex belongs to a triangle at a neighbour, and an edge to the triangle of such a patch.
  slots.clear();
  for (const TriangleId slot : model.elements().incident_slots().row(vertex)) {
    for (const VertexId w : triangle_at(model, slot).vertex) {
      const std::span<const TriangleId> around = model.elements().incident_slots().row(w);
      slots.insert(slots.end(), around.begin(), around.end());
    }
  }
  std::sort(slots.begin(), slots.end());
  slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  for (const TriangleId slot : slots) {
    const BendingPatch& patch = model.bending().terms(model.element_blocks()).patches[static_cast<std::size_t>(slot)];
    const double of_patch = row_sum_of(patch.vertex, vertex, [&](std::size_t a, std::size_t b) {
      return std::abs(patch.at(static_cast<int>(a), static_cast<int>(b))) + excess_at(model, slot, a, b);
    });
    if (of_patch >= 0.0) parts.push_back({StiffPart::patch(slot), of_patch});
    for (const BendingEdge& edge : model.bending().edges().row(slot)) {
      const double of_edge =
          row_sum_of(edge.vertex, vertex, [&](std::size_t a, std::size_t b) { return edge.at(a, b); });
      if (of_edge >= 0.0) parts.push_back({StiffPart::edge(slot, edge.first_edge), of_edge});
    }
  }
  std::sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.part < b.part; });
}

}  // namespace kerf::fem
