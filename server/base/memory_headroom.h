#pragma once

#include <cstdint>

namespace kerf {

// Bytes that any work with memory in proportion to a sheet leaves free, so that small allocations elsewhere do not
// fail.
inline constexpr std::int64_t kMemoryHeadroom = std::int64_t{48} << 20;

// Returns true if this process can allocate `bytes` (>= 0) and still has kMemoryHeadroom left. Checks memory_limit(),
// the address space and the memory available on the machine. Costs some 20 microseconds.
[[nodiscard]] bool has_memory_for(std::int64_t bytes);
// Returns true if this process is at least kMemoryHeadroom below its own limits. Memory that other programs use does
// not count.
[[nodiscard]] bool is_within_memory_limit();

}  // namespace kerf
