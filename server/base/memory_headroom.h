#pragma once

#include <cstdint>

namespace kerf {

// Bytes that work as large as a sheet leaves to everything else, so that no small allocation fails.
inline constexpr std::int64_t kMemoryHeadroom = std::int64_t{48} << 20;

// True where this process may have `bytes`, >= 0, and kMemoryHeadroom besides, of memory_limit(), of its address space
// and of what the machine has to give. Costs some 20 microseconds.
[[nodiscard]] bool has_memory_for(std::int64_t bytes);
// The same of kMemoryHeadroom alone, whatever other programs leave: of limits that are this process's own.
[[nodiscard]] bool is_within_memory_limit();

}  // namespace kerf
