#include "server/core/fem/model/running_maximum.h"

#include <algorithm>
#include <array>

namespace kerf::fem {

void RunningMaximum::resize(std::size_t size) {
  if (levels_.empty()) levels_.emplace_back();
  const std::size_t before = levels_.front().size();
  if (size == before) return;
  std::size_t level = 0;
  for (std::size_t n = size;; n = (n + kGroup - 1) / kGroup) {
    if (level == levels_.size()) levels_.emplace_back();
    levels_[level++].resize(n, 0.0);
    if (n <= 1) break;
  }
  levels_.resize(level);
  // If values were dropped, the last group of each level lost some of its members. A new level at the top is still
  // empty. Updating the first and the last value repairs the maxima of both up to the top.
  if (size > 0) {
    const std::array<std::int32_t, 2> ends{0, static_cast<std::int32_t>(size - 1)};
    update(ends);
  }
}

void RunningMaximum::update(std::span<const std::int32_t> changed) {
  std::vector<std::size_t> groups(changed.begin(), changed.end());
  for (std::size_t level = 1; level < levels_.size(); ++level) {
    // Ids come in runs: dropping consecutive repetitions leaves few.
    for (std::size_t& i : groups) i /= kGroup;
    groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
    const std::vector<double>& below = levels_[level - 1];
    for (const std::size_t i : groups) {
      const auto first = below.begin() + static_cast<std::ptrdiff_t>(i * kGroup);
      const auto last = below.begin() + static_cast<std::ptrdiff_t>(std::min((i + 1) * kGroup, below.size()));
      levels_[level][i] = *std::max_element(first, last);
    }
  }
}

}  // namespace kerf::fem
