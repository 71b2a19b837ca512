#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace kerf::linear {

// Rows of varying length in one array. A sweep over all rows reads memory nearly in order, while a single row can be
// replaced without moving the others. A row that outgrows its place moves to the end. The array is packed again once
// more than half of it is holes.
template <typename Entry>
class RowStore {
 public:
  [[nodiscard]] int num_rows() const { return static_cast<int>(rows_.size()); }
  [[nodiscard]] std::size_t num_entries() const { return num_entries_; }
  [[nodiscard]] std::span<const Entry> row(int i) const {
    const Row& r = rows_[static_cast<std::size_t>(i)];
    return {entries_.data() + r.begin, r.size};
  }

  // Adds empty rows or drops the rows beyond `num_rows`.
  void resize(int num_rows) {
    for (int i = num_rows; i < this->num_rows(); ++i) num_entries_ -= rows_[static_cast<std::size_t>(i)].size;
    rows_.resize(static_cast<std::size_t>(num_rows));
  }

  // Removes all rows and keeps the storage.
  void clear() {
    rows_.clear();
    entries_.clear();
    num_entries_ = 0;
  }

  // Reserves storage for `num_rows` rows with `num_entries` entries in all, if each row is written once after clear().
  // If the storage has to grow it takes a quarter more. Invalidates spans of rows.
  void make_room(int num_rows, std::size_t num_entries) {
    const auto n = static_cast<std::size_t>(num_rows);
    if (rows_.capacity() < n) rows_.reserve(n + n / 4);
    if (entries_.capacity() < num_entries) entries_.reserve(num_entries + num_entries / 4);
  }

  // Reserves a quarter more entries, so that rows may outgrow their places for some time before the array is moved.
  // Invalidates spans of rows.
  void make_room() { entries_.reserve(entries_.size() + entries_.size() / 4); }

  // Replaces the content of row i. Invalidates spans of rows.
  void set_row(int i, std::span<const Entry> content) {
    std::copy(content.begin(), content.end(), resize_row(i, content.size()).begin());
  }

  // Returns row i resized to `size` entries, all of which must be written. Invalidates spans of rows.
  std::span<Entry> resize_row(int i, std::size_t size) {
    Row& r = rows_[static_cast<std::size_t>(i)];
    num_entries_ += size;
    num_entries_ -= r.size;
    if (size > r.capacity) {
      r.begin = entries_.size();
      r.capacity = size;
      entries_.resize(entries_.size() + size);
    }
    r.size = size;
    if (entries_.size() > 2 * num_entries_ + kSlack) pack();
    return {entries_.data() + r.begin, size};
  }

 private:
  struct Row {
    std::size_t begin = 0;
    std::size_t size = 0;
    std::size_t capacity = 0;
  };
  static constexpr std::size_t kSlack = 1024;  // entries; packing smaller arrays gains nothing

  void pack() {
    std::vector<Entry> packed;
    packed.reserve(num_entries_ + num_entries_ / 4);
    for (Row& r : rows_) {
      const auto from = entries_.begin() + static_cast<std::ptrdiff_t>(r.begin);
      r.begin = packed.size();
      r.capacity = r.size;
      packed.insert(packed.end(), from, from + static_cast<std::ptrdiff_t>(r.size));
    }
    entries_ = std::move(packed);
  }

  std::vector<Row> rows_;
  std::vector<Entry> entries_;
  std::size_t num_entries_ = 0;
};

}  // namespace kerf::linear
