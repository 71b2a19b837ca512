#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kerf::fem {

// A set of ids in [0, n), kept from one edit to the next: insertion and lookup take constant time, clearing takes the
// time of the members. A bit an id, so that the part of it that an edit of a large sheet looks at stays near.
class IdSet {
 public:
  // For ids below n; never shrinks, and grows by an eighth, so that it seldom has to.
  void resize(std::size_t n) {
    if (n > 64 * words_.size()) words_.resize((n + n / 8) / 64 + 1, 0);
  }
  void clear() {
    for (const std::int32_t id : members_) words_[word_of(id)] = 0;
    members_.clear();
  }
  // Whether `id` is new.
  bool insert(std::int32_t id) {
    if (contains(id)) return false;
    words_[word_of(id)] |= bit_of(id);
    members_.push_back(id);
    return true;
  }
  [[nodiscard]] bool contains(std::int32_t id) const { return (words_[word_of(id)] & bit_of(id)) != 0; }
  // In the order of insertion.
  [[nodiscard]] std::span<const std::int32_t> members() const { return members_; }
  [[nodiscard]] std::size_t size() const { return members_.size(); }

 private:
  static std::size_t word_of(std::int32_t id) { return static_cast<std::size_t>(id) / 64; }
  static std::uint64_t bit_of(std::int32_t id) { return std::uint64_t{1} << (static_cast<std::uint32_t>(id) % 64U); }

  std::vector<std::uint64_t> words_;
  std::vector<std::int32_t> members_;
};

// The same, with the place of each id in the order of insertion at hand: 4 bytes an id.
class IndexSet {
 public:
  // For ids below n; never shrinks.
  void resize(std::size_t n) {
    if (n > place_.size()) place_.resize(n, -1);
  }
  void clear() {
    for (const std::int32_t id : members_) place_[static_cast<std::size_t>(id)] = -1;
    members_.clear();
  }
  // Whether `id` is new.
  bool insert(std::int32_t id) {
    std::int32_t& place = place_[static_cast<std::size_t>(id)];
    if (place >= 0) return false;
    place = static_cast<std::int32_t>(members_.size());
    members_.push_back(id);
    return true;
  }
  [[nodiscard]] bool contains(std::int32_t id) const { return place(id) >= 0; }
  // Into members(), or -1.
  [[nodiscard]] std::int32_t place(std::int32_t id) const { return place_[static_cast<std::size_t>(id)]; }
  // In the order of insertion.
  [[nodiscard]] std::span<const std::int32_t> members() const { return members_; }
  [[nodiscard]] std::size_t size() const { return members_.size(); }

 private:
  std::vector<std::int32_t> place_;
  std::vector<std::int32_t> members_;
};

}  // namespace kerf::fem
