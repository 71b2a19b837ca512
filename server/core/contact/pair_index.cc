#include "server/core/contact/pair_index.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace kerf::contact {

using mesh::VertexId;

void PairIndex::set(const std::array<std::vector<std::int32_t>, 4>& vertices, std::size_t count,
                    std::size_t num_vertices) {
  first_.assign(num_vertices + 1, 0);
  for (const std::vector<std::int32_t>& of : vertices) {
    for (std::size_t p = 0; p < count; ++p) ++first_[static_cast<std::size_t>(of[p])];
  }
  std::int32_t end = 0;
  for (std::int32_t& first : first_) first = end += first;
  pairs_.resize(4 * count);
  // Fills the places of each vertex from behind, after which first_ is where they begin.
  for (const std::vector<std::int32_t>& of : vertices) {
    for (std::size_t p = 0; p < count; ++p) {
      pairs_[static_cast<std::size_t>(--first_[static_cast<std::size_t>(of[p])])] = static_cast<std::int32_t>(p);
    }
  }
  is_found_.assign(count / 64 + 1, 0);
}

void PairIndex::find(std::span<const VertexId> vertices, std::vector<std::int32_t>& found) {
  found.clear();
  for (const VertexId v : vertices) {
    const auto begin = pairs_.begin() + first_[static_cast<std::size_t>(v)];
    const auto end = pairs_.begin() + first_[static_cast<std::size_t>(v) + 1];
    for (auto p = begin; p != end; ++p) is_found_[static_cast<std::size_t>(*p / 64)] |= std::uint64_t{1} << (*p % 64);
  }
  for (std::size_t word = 0; word < is_found_.size(); ++word) {
    std::uint64_t bits = std::exchange(is_found_[word], 0);
    for (; bits != 0; bits &= bits - 1) found.push_back(static_cast<std::int32_t>(64 * word) + std::countr_zero(bits));
  }
}

}  // namespace kerf::contact
