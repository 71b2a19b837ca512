#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/fem/element/bending.h"
#include "server/core/linear/rank_ascending.h"
#include "server/core/linear/row_store.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// One row of a matrix while it is summed. Entries of a column are summed in the order in which they are added.
class RowSum {
 public:
  // Makes room for columns below n; never shrinks.
  void resize(std::size_t n) {
    if (place_.size() > n) return;
    place_.resize(n + 1, kNew);
    place_[0] = kNowhere;
  }

  // Adds entries. Columns may repeat; entries of column kNone are ignored.
  template <std::size_t N>
  void add(const std::array<mesh::VertexId, N>& columns, const std::array<double, N>& entries) {
    if (values_.size() < size_ + N) values_.resize(2 * (size_ + N)), columns_.resize(2 * (size_ + N));
    // Branches would be unpredictable here, so there are none. All that the loop writes is reached by local pointers,
    // so that the compiler need not reload members.
    std::int32_t* const place_of = place_.data() + 1;
    double* const values = values_.data();
    mesh::VertexId* const met = columns_.data();
    auto size = static_cast<std::int32_t>(size_);
    for (std::size_t i = 0; i < N; ++i) {
      const mesh::VertexId column = columns[i];
      const std::int32_t known = place_of[column];
      const bool is_new = known < 0;
      const std::int32_t place = is_new ? size : known;
      size += is_new ? 1 : 0;
      place_of[column] = place;
      met[place] = column;
      values[place] = (is_new ? -0.0 : values[place]) + entries[i];  // -0.0 + x is x, of any sign
    }
    size_ = static_cast<std::size_t>(size);
  }

  // Moves the sum to a row of `rows`, by ascending column, and empties this.
  void move_to(linear::RowStore<BendingEntry>& rows, int row) {
    const std::span<const mesh::VertexId> columns(columns_.data() + 1, size_ - 1);
    linear::rank_ascending(columns, order_);
    const std::span<BendingEntry> made = rows.resize_row(row, columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      made[static_cast<std::size_t>(order_[i])] = {values_[1 + i], columns[i]};
      place_[static_cast<std::size_t>(columns[i] + 1)] = kNew;
    }
    size_ = 1;
  }

 private:
  static constexpr std::int32_t kNew = -1;
  static constexpr std::int32_t kNowhere = 0;  // place of entries of column kNone

  std::size_t size_ = 1;                 // places taken
  std::vector<std::int32_t> place_;      // by column + 1
  std::vector<mesh::VertexId> columns_;  // by place
  std::vector<double> values_;           // by place
  std::vector<std::int32_t> order_;
};

}  // namespace kerf::fem
