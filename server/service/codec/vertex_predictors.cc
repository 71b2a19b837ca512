#include "server/service/codec/vertex_predictors.h"

#include <algorithm>

namespace kerf::codec {
namespace {

using Triangle = std::array<std::int32_t, 3>;

// Lists the slots around each vertex, all lists in one array.
struct SlotsAround {
  std::vector<std::size_t> begins;  // Start of each vertex's list in `slots`, and the end of the last list.
  std::vector<std::size_t> slots;

  SlotsAround(std::span<const Triangle> triangles, std::size_t num_vertices) : begins(num_vertices + 1, 0) {
    for (const Triangle& triangle : triangles) {
      if (triangle[0] == kNoVertex) continue;
      for (const std::int32_t vertex : triangle) ++begins[static_cast<std::size_t>(vertex) + 1];
    }
    for (std::size_t v = 0; v < num_vertices; ++v) begins[v + 1] += begins[v];
    slots.resize(begins[num_vertices]);
    std::vector<std::size_t> ends(begins.begin(), begins.end() - 1);
    for (std::size_t slot = 0; slot < triangles.size(); ++slot) {
      if (triangles[slot][0] == kNoVertex) continue;
      for (const std::int32_t vertex : triangles[slot]) slots[ends[static_cast<std::size_t>(vertex)]++] = slot;
    }
  }
  [[nodiscard]] std::span<const std::size_t> of(std::int32_t vertex) const {
    const auto v = static_cast<std::size_t>(vertex);
    return std::span(slots).subspan(begins[v], begins[v + 1] - begins[v]);
  }
};

std::int32_t find_across(std::span<const Triangle> triangles, const SlotsAround& around, std::int32_t vertex,
                         const VertexPredictor& near) {
  std::int32_t across = kNoVertex;
  for (const std::size_t slot : around.of(near.near_a)) {
    const Triangle& triangle = triangles[slot];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = triangle[(k + 1) % 3];
      const std::int32_t to = triangle[(k + 2) % 3];
      const bool shares_edge = (from == near.near_a && to == near.near_b) || (from == near.near_b && to == near.near_a);
      if (shares_edge && triangle[k] < vertex && (across == kNoVertex || triangle[k] < across)) across = triangle[k];
    }
  }
  return across;
}

}  // namespace

std::vector<VertexPredictor> vertex_predictors(std::span<const Triangle> triangles, std::size_t num_vertices) {
  std::vector<VertexPredictor> predictors(num_vertices);
  std::vector<std::int32_t> neighbours(num_vertices, kNoVertex);  // near_a of vertices that are the highest in no slot.
  for (const Triangle& triangle : triangles) {
    if (triangle[0] == kNoVertex) continue;
    const std::int32_t lowest = std::min({triangle[0], triangle[1], triangle[2]});
    for (std::size_t k = 0; k < 3; ++k) {
      const auto vertex = static_cast<std::size_t>(triangle[k]);
      const std::int32_t from = triangle[(k + 1) % 3];
      const std::int32_t to = triangle[(k + 2) % 3];
      VertexPredictor& predictor = predictors[vertex];
      if (predictor.near_a == kNoVertex && from < triangle[k] && to < triangle[k]) predictor = {from, to, kNoVertex};
      if (neighbours[vertex] == kNoVertex && lowest < triangle[k]) neighbours[vertex] = lowest;
    }
  }
  const SlotsAround around(triangles, num_vertices);
  for (std::size_t v = 0; v < num_vertices; ++v) {
    const auto vertex = static_cast<std::int32_t>(v);
    if (predictors[v].near_a == kNoVertex) {
      // The first vertex gets -1, which is kNoVertex.
      predictors[v].near_a = neighbours[v] == kNoVertex ? vertex - 1 : neighbours[v];
    } else {
      predictors[v].across = find_across(triangles, around, vertex, predictors[v]);
    }
  }
  return predictors;
}

}  // namespace kerf::codec
