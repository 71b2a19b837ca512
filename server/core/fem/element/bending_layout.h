#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/fem/element/bending.h"
#include "server/core/linear/lanes16.h"
#include "server/core/linear/row_store.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// One entry in each of four neighbouring rows of the bending matrix, for vector code. Rows shorter than the longest of
// the four are padded with 0 at their own vertex.
template <typename T>
struct FourEntries {
  static constexpr std::size_t kRows = 4;
  std::array<std::int32_t, kRows> place{};  // 4 x column: where x, y, z and 0 of the column's vertex begin in an array
                                            // "x 4"
  std::array<T, kRows> value{};             // N/m
};

// The bending matrix without its diagonal, arranged for multiplication in vector code, by blocks of vertices. Entries
// of several rows of a block at the same distance column - row multiply contiguous positions. They are stored as one
// diagonal of the block. All other entries, the rest, are stored by rows, four vertices side by side. The layout
// follows from the matrix alone.
template <typename T>
class BendingLayout {
 public:
  // Least number of entries of a diagonal; fewer entries at one distance cost less when stored by rows.
  static constexpr std::uint32_t kLeastInDiagonal = 7;
  static constexpr int kRowsInGroup = static_cast<int>(FourEntries<T>::kRows);
  static constexpr int kGroupsInBlock = static_cast<int>(linear::kBlockLanes) / kRowsInGroup;

  [[nodiscard]] int num_groups() const { return rest_.num_rows(); }
  [[nodiscard]] bool has_rest() const { return rest_.num_entries() > 0; }
  // Distances column - row of the diagonals of a block, ascending.
  [[nodiscard]] std::span<const std::int32_t> offsets(std::size_t block) const {
    return offsets_.row(static_cast<int>(block));
  }
  // N/m, entries of each diagonal, in the order of offsets(); 0 where a row has none.
  [[nodiscard]] std::span<const linear::Lanes16<T>> diagonals(std::size_t block) const {
    return diagonals_.row(static_cast<int>(block));
  }
  // Returns the entries of a group of four rows that lie in no diagonal. The entries of each row are in the order of
  // columns.
  [[nodiscard]] std::span<const FourEntries<T>> rest(int group) const { return rest_.row(group); }

  // Drops all entries and keeps the storage.
  void clear() {
    offsets_.clear();
    diagonals_.clear();
    rest_.clear();
  }
  // Reserves storage for the content of `like`, so that setting it does not allocate.
  template <typename U>
  void make_room_as(const BendingLayout<U>& like) {
    offsets_.make_room(like.offsets_.num_rows(), like.offsets_.num_entries());
    diagonals_.make_room(like.diagonals_.num_rows(), like.diagonals_.num_entries());
    rest_.make_room(like.rest_.num_rows(), like.rest_.num_entries());
    if (place_of_.capacity() < like.place_of_.size()) place_of_.reserve(like.place_of_.size() * 5 / 4);
    found_.reserve(like.found_.capacity());
    seen_.reserve(like.seen_.capacity());
    others_.reserve(like.others_.capacity());
  }
  // Changes the number of vertices. New blocks are empty until they are set.
  void resize(int num_vertices) {
    constexpr auto kLanesInBlock = static_cast<int>(linear::kBlockLanes);
    const int num_blocks = (num_vertices + kLanesInBlock - 1) / kLanesInBlock;
    offsets_.resize(num_blocks);
    diagonals_.resize(num_blocks);
    rest_.resize((num_vertices + kRowsInGroup - 1) / kRowsInGroup);
    place_of_.resize(2 * static_cast<std::size_t>(num_vertices));
  }

  // Sets a block from rows of as many vertices as resize() was called with.
  void set_block(const linear::RowStore<BendingEntry>& rows, std::size_t block) {
    const auto first = static_cast<mesh::VertexId>(block * linear::kBlockLanes);
    const mesh::VertexId last = std::min(first + static_cast<mesh::VertexId>(linear::kBlockLanes), rows.num_rows());
    find_diagonals(rows, first, last);
    const std::span<std::int32_t> offsets = offsets_.resize_row(static_cast<int>(block), found_.size());
    std::copy(found_.begin(), found_.end(), offsets.begin());
    const std::span<linear::Lanes16<T>> diagonals = diagonals_.resize_row(static_cast<int>(block), found_.size());
    std::fill(diagonals.begin(), diagonals.end(), linear::Lanes16<T>{});
    others_.clear();
    std::array<std::size_t, linear::kBlockLanes + 1> ends{};  // ends in others_ of the entries before each row
    for (mesh::VertexId v = first; v < last; ++v) {
      const auto lane = static_cast<std::size_t>(v - first);
      for (const BendingEntry& entry : rows.row(v)) {
        const std::uint32_t place = place_of(rows, entry.column - v);
        if (place >= kFirstPlace) {
          diagonals[place - kFirstPlace].lane[lane] = static_cast<T>(entry.value);
        } else if (entry.column != v) {
          others_.push_back(entry);
        }
      }
      ends[lane + 1] = others_.size();
    }
    for (mesh::VertexId v = first; v < last; v += kRowsInGroup) {
      const auto lane = static_cast<std::size_t>(v - first);
      const auto num_rows = static_cast<std::size_t>(std::min(last - v, kRowsInGroup));
      set_rest(v, std::span(ends).subspan(lane, num_rows + 1));
    }
    for (const std::int32_t offset : seen_) place_of(rows, offset) = 0;
  }

 private:
  template <typename U>
  friend class BendingLayout;
  static constexpr std::uint32_t kFirstPlace = 1000;  // greater than any count

  // While diagonals are sought, this is the number of rows of the block with an entry at the distance `offset`.
  // Afterwards it is kFirstPlace plus the index of the diagonal, if the distance has one.
  std::uint32_t& place_of(const linear::RowStore<BendingEntry>& rows, std::int32_t offset) {
    return place_of_[static_cast<std::size_t>(offset + rows.num_rows())];
  }

  // Sets found_ and seen_, and place_of() for the distances in them.
  void find_diagonals(const linear::RowStore<BendingEntry>& rows, mesh::VertexId first, mesh::VertexId last) {
    found_.clear();
    seen_.clear();
    for (mesh::VertexId v = first; v < last; ++v) {
      for (const BendingEntry& entry : rows.row(v)) {
        if (entry.column == v) continue;
        const std::uint32_t count = ++place_of(rows, entry.column - v);
        if (count == 1) seen_.push_back(entry.column - v);
        if (count == kLeastInDiagonal) found_.push_back(entry.column - v);
      }
    }
    std::sort(found_.begin(), found_.end());
    for (std::size_t k = 0; k < found_.size(); ++k) {
      place_of(rows, found_[k]) = kFirstPlace + static_cast<std::uint32_t>(k);
    }
  }

  // Stores the entries of others_ in the rows of up to four vertices from v on as one group of rest_. Those of row
  // v + r are from ends[r] to before ends[r + 1] in others_.
  void set_rest(mesh::VertexId v, std::span<const std::size_t> ends) {
    std::size_t longest = 0;
    for (std::size_t r = 0; r + 1 < ends.size(); ++r) longest = std::max(longest, ends[r + 1] - ends[r]);
    const std::span<FourEntries<T>> entries = rest_.resize_row(v / kRowsInGroup, longest);
    for (std::size_t r = 0; r < FourEntries<T>::kRows; ++r) {
      const std::size_t size = r + 1 < ends.size() ? ends[r + 1] - ends[r] : 0;
      for (std::size_t k = 0; k < size; ++k) {
        const BendingEntry& entry = others_[ends[r] + k];
        entries[k].place[r] = 4 * entry.column;
        entries[k].value[r] = static_cast<T>(entry.value);
      }
      for (std::size_t k = size; k < longest; ++k) {
        entries[k].place[r] = 4 * (v + static_cast<mesh::VertexId>(r));
        entries[k].value[r] = 0;
      }
    }
  }

  linear::RowStore<std::int32_t> offsets_;
  linear::RowStore<linear::Lanes16<T>> diagonals_;
  linear::RowStore<FourEntries<T>> rest_;

  // Scratch of set_block().
  std::vector<std::int32_t> found_;      // distances of the block's diagonals, ascending
  std::vector<std::int32_t> seen_;       // all distances that occur in the block
  std::vector<std::uint32_t> place_of_;  // by distance + number of vertices; 0 outside of set_block()
  std::vector<BendingEntry> others_;     // the block's entries that lie in none of its diagonals, row by row
};

}  // namespace kerf::fem
