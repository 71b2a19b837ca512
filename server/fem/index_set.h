#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kerf::fem {

// A set of ids in [0, n), kept from one edit to the next so that nothing of size n is allocated or cleared: insertion,
// lookup and the place in the order of insertion take constant time, clearing takes the time of the members.
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
