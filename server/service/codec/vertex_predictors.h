#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kerf::codec {

inline constexpr std::int32_t kNoVertex = -1;

// Holds the earlier vertices that predict a vertex: ids below its own, or kNoVertex if there is none.
//
//      near_a                 near_a and near_b are the other corners of the first slot in which the vertex has the
//      /    \                 highest id of the three; across is the lowest id that forms a triangle with those two on
//  across   vertex            their other side. A vertex that is the highest in no slot has near_a alone: the lowest
//      \    /                 corner of the first slot in which it is not the lowest itself, or else id - 1.
//      near_b
struct VertexPredictor {
  std::int32_t near_a = kNoVertex;
  std::int32_t near_b = kNoVertex;
  std::int32_t across = kNoVertex;

  bool operator==(const VertexPredictor&) const = default;
};

// Returns the predictors of num_vertices vertices. They depend on the triangles alone, so a viewer that has the
// triangles finds the same predictors. `triangles`: one per slot; vertex ids in 0..num_vertices-1, or kNoVertex thrice
// in an empty slot. O(vertices + slots).
std::vector<VertexPredictor> vertex_predictors(std::span<const std::array<std::int32_t, 3>> triangles,
                                               std::size_t num_vertices);

}  // namespace kerf::codec
