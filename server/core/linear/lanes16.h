#pragma once

#include <array>
#include <cstddef>

namespace kerf::fem {

// Lanes of a block of vector code: a fixed number, a multiple of what any processor does at once, so that results do
// not depend on the processor.
inline constexpr std::size_t kBlockLanes = 16;

template <typename T>
struct alignas(64) Lanes16 {
  std::array<T, kBlockLanes> lane{};
};

}  // namespace kerf::fem
