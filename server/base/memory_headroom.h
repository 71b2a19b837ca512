#pragma once

#include <cstdint>

namespace kerf {

// Bytes that work as large as a sheet leaves to everything else, so that no small allocation fails.
inline constexpr std::int64_t kMemoryHeadroom = std::int64_t{48} << 20;

// Returns true if this process can allocate `bytes` (>= 0) and still has kMemoryHeadroom left. Checks memory_limit(),
// the address space and the memory available on the machine. Costs some 20 microseconds.
[[nodiscard]] bool has_memory_for(std::int64_t bytes);
// Returns true if kMemoryHeadroom is left within this process's own limits, whatever memory other programs use.
[[nodiscard]] bool is_within_memory_limit();

}  // namespace kerf
