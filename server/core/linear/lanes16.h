#pragma once

#include <array>
#include <cstddef>

namespace kerf::linear {

// Number of lanes of a block in vector code. It is fixed, a multiple of any processor's vector length, so that results
// do not depend on the processor.
inline constexpr std::size_t kBlockLanes = 16;

template <typename T>
struct alignas(64) Lanes16 {
  std::array<T, kBlockLanes> lane{};
};

}  // namespace kerf::linear
