#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kerf::linear {

// A set of ids in [0, n), kept from one edit to the next. Insertion and lookup take constant time, clearing is linear
// in the number of members. It uses one bit an id, so that the few words that an edit touches stay in cache.
class IdSet {
 public:
  // Makes room for ids below n. Never shrinks, and grows by an eighth more, so that it seldom has to.
  void resize(std::size_t n) {
    if (n > 64 * words_.size()) words_.resize((n + n / 8) / 64 + 1, 0);
  }
  void clear() {
    for (const std::int32_t id : members_) words_[word_of(id)] = 0;
    members_.clear();
  }
  // Returns true if `id` is new.
  bool insert(std::int32_t id) {
    if (contains(id)) return false;
    words_[word_of(id)] |= bit_of(id);
    members_.push_back(id);
    return true;
  }
  [[nodiscard]] bool contains(std::int32_t id) const { return (words_[word_of(id)] & bit_of(id)) != 0; }
  // Members in the order of insertion.
  [[nodiscard]] std::span<const std::int32_t> members() const { return members_; }
  [[nodiscard]] std::size_t size() const { return members_.size(); }

 private:
  static std::size_t word_of(std::int32_t id) { return static_cast<std::size_t>(id) / 64; }
  static std::uint64_t bit_of(std::int32_t id) { return std::uint64_t{1} << (static_cast<std::uint32_t>(id) % 64U); }

  std::vector<std::uint64_t> words_;
  std::vector<std::int32_t> members_;
};

// A set like IdSet that also gives the place of each id in the order of insertion; 4 bytes an id.
class IndexSet {
 public:
  // Makes room for ids below n. Never shrinks.
  void resize(std::size_t n) {
    if (n > place_.size()) place_.resize(n, -1);
  }
  void clear() {
    for (const std::int32_t id : members_) place_[static_cast<std::size_t>(id)] = -1;
    members_.clear();
  }
  // Returns true if `id` is new.
  bool insert(std::int32_t id) {
    std::int32_t& place = place_[static_cast<std::size_t>(id)];
    if (place >= 0) return false;
    place = static_cast<std::int32_t>(members_.size());
    members_.push_back(id);
    return true;
  }
  [[nodiscard]] bool contains(std::int32_t id) const { return place(id) >= 0; }
  // Returns the index of `id` in members(), or -1.
  [[nodiscard]] std::int32_t place(std::int32_t id) const { return place_[static_cast<std::size_t>(id)]; }
  // Members in the order of insertion.
  [[nodiscard]] std::span<const std::int32_t> members() const { return members_; }
  [[nodiscard]] std::size_t size() const { return members_.size(); }

 private:
  std::vector<std::int32_t> place_;
  std::vector<std::int32_t> members_;
};

}  // namespace kerf::linear
