#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/mesh/ids.h"

namespace kerf::contact {

// Finds those of many pairs that have one of a few vertices.
class PairIndex {
 public:
  // Sets up the index of the first `count` pairs, whose vertices are side by side.
  void set(const std::array<std::vector<std::int32_t>, 4>& vertices, std::size_t count, std::size_t num_vertices);
  // Fills `found` with the indices of pairs, ascending, that have one of `vertices`.
  void find(std::span<const mesh::VertexId> vertices, std::vector<std::int32_t>& found);

 private:
  std::vector<std::int32_t> first_;  // in pairs_, by vertex id
  std::vector<std::int32_t> pairs_;
  std::vector<std::uint64_t> is_found_;  // scratch: a bit for each pair
};

}  // namespace kerf::contact
