#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kerf::fem {

// The largest of many values >= 0. A tree of group maxima keeps it up to date as some values change.
class RunningMaximum {
 public:
  [[nodiscard]] double value() const {
    return levels_.empty() || levels_.back().empty() ? 0.0 : levels_.back().front();
  }
  [[nodiscard]] double value(std::size_t i) const { return levels_.front()[i]; }
  // Sets the number of values. New values are 0; values beyond `size` are dropped.
  void resize(std::size_t size);
  void set(std::size_t i, double value) { levels_.front()[i] = value; }
  // Updates the maxima after set() of each of `changed`.
  void update(std::span<const std::int32_t> changed);

 private:
  static constexpr std::size_t kGroup = 16;
  std::vector<std::vector<double>>
      levels_;  // the values, maxima of groups of kGroup values, maxima of groups of those, ..., the largest
};

}  // namespace kerf::fem
