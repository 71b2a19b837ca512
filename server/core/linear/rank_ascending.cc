#include "server/core/linear/rank_ascending.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "server/core/linear/lanes16.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/linear/rank_ascending.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::linear {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Both arrays have room for a multiple of kBlockLanes.
void count_below(const std::int32_t* keys, std::size_t size, std::int32_t* counts) {
  const hn::CappedTag<std::int32_t, kBlockLanes> d;
  for (std::size_t i = 0; i < size; i += hn::Lanes(d)) {
    const auto some = hn::LoadU(d, keys + i);
    auto below = hn::Zero(d);
    for (std::size_t k = 0; k < size; ++k) below = hn::Sub(below, hn::VecFromMask(d, hn::Set(d, keys[k]) < some));
    hn::StoreU(below, d, counts + i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::linear
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::linear {
namespace {
HWY_EXPORT(count_below);
}  // namespace

void rank_ascending(std::span<const std::int32_t> keys, std::vector<std::int32_t>& places) {
  constexpr std::size_t kFew = 64;
  static_assert(kFew % kBlockLanes == 0);
  places.resize(keys.size());
  if (keys.size() <= kFew) {
    std::array<std::int32_t, kFew> few;
    std::array<std::int32_t, kFew> counts;
    std::fill_n(std::copy(keys.begin(), keys.end(), few.begin()), (kFew - keys.size()) % kBlockLanes, 0);
    HWY_DYNAMIC_DISPATCH(count_below)(few.data(), keys.size(), counts.data());
    std::copy_n(counts.begin(), keys.size(), places.begin());
    return;
  }
  std::vector<std::int32_t> sorted(keys.begin(), keys.end());
  std::sort(sorted.begin(), sorted.end());
  std::transform(keys.begin(), keys.end(), places.begin(), [&](std::int32_t key) {
    return static_cast<std::int32_t>(std::lower_bound(sorted.begin(), sorted.end(), key) - sorted.begin());
  });
}

}  // namespace kerf::linear
#endif  // HWY_ONCE
