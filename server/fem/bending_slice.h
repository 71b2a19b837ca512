#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <span>

#include "server/fem/bending.h"
#include "server/fem/membrane_layout.h"
#include "server/fem/row_store.h"
#include "server/mesh/ids.h"

namespace kerf::fem {

// Rows of the bending matrix of a block of vertices by the distance of their columns in vertex ids, ascending: entries
// at one distance meet contiguous positions. A row's missing ones are 0 and do not change its sum.
template <typename T>
struct BendingSlice {
  static constexpr std::int32_t kUnused = -1;  // too many distances
  static constexpr std::int32_t kStale = -2;
  static constexpr std::size_t kMaxDiagonals = 40;
  std::int32_t num_diagonals = kUnused;  // < 0: go by rows
  std::array<std::int32_t, kMaxDiagonals> offset{};
  std::array<Lanes16<T>, kMaxDiagonals> value{};  // N/m
};

// Unused where there are more than kMaxDiagonals, or some beyond `reach`.
template <typename T>
BendingSlice<T> make_bending_slice(const RowStore<BendingEntry>& rows, std::size_t block, std::int32_t reach) {
  BendingSlice<T> slice;
  const auto first = static_cast<mesh::VertexId>(block * kBlockLanes);
  const mesh::VertexId last = std::min(first + static_cast<mesh::VertexId>(kBlockLanes), rows.num_rows());
  const auto offsets = slice.offset.begin();
  std::ptrdiff_t n = 0;
  for (mesh::VertexId v = first; v < last; ++v) {
    for (const BendingEntry& entry : rows.row(v)) {
      const std::int32_t offset = entry.column - v;
      const auto found = std::lower_bound(offsets, offsets + n, offset);
      const auto k = found - offsets;
      if (k == n || *found != offset) {
        if (n == std::ssize(slice.offset) || std::abs(offset) > reach) return slice;
        std::copy_backward(found, offsets + n, offsets + n + 1);
        std::copy_backward(slice.value.begin() + k, slice.value.begin() + n, slice.value.begin() + n + 1);
        *found = offset;
        slice.value[static_cast<std::size_t>(k)] = {};
        ++n;
      }
      slice.value[static_cast<std::size_t>(k)].lane[static_cast<std::size_t>(v - first)] = static_cast<T>(entry.value);
    }
  }
  slice.num_diagonals = static_cast<std::int32_t>(n);
  return slice;
}

// One entry each of four neighbouring rows of the bending matrix, for vector code. A row that has fewer than the
// longest of the four meets its own vertex with 0.
template <typename T>
struct FourEntries {
  static constexpr std::size_t kRows = 4;
  std::array<std::int32_t, kRows> place{};  // 4 x column: of its x, y, z, 0 in an array of such
  std::array<T, kRows> value{};             // N/m
};

// Into row `group` of `made`: of rows 4 group, ..., 4 group + 3, in the order of their columns.
template <typename T>
void set_four_rows(const RowStore<BendingEntry>& rows, int group, RowStore<FourEntries<T>>& made) {
  constexpr auto kRows = static_cast<int>(FourEntries<T>::kRows);
  std::array<std::span<const BendingEntry>, FourEntries<T>::kRows> four;
  std::size_t longest = 0;
  for (int r = 0; r < kRows; ++r) {
    const mesh::VertexId v = kRows * group + r;
    if (v >= rows.num_rows()) break;
    four[static_cast<std::size_t>(r)] = rows.row(v);
    longest = std::max(longest, rows.row(v).size());
  }
  const std::span<FourEntries<T>> entries = made.resize_row(group, longest);
  for (std::size_t r = 0; r < four.size(); ++r) {
    const std::span<const BendingEntry> row = four[r];
    for (std::size_t k = 0; k < row.size(); ++k) {
      entries[k].place[r] = 4 * row[k].column;
      entries[k].value[r] = static_cast<T>(row[k].value);
    }
    for (std::size_t k = row.size(); k < longest; ++k) {
      entries[k].place[r] = 4 * (kRows * group + static_cast<int>(r));
      entries[k].value[r] = 0;
    }
  }
}

}  // namespace kerf::fem
