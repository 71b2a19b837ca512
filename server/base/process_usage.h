#pragma once

#include <cstdint>
#include <optional>

namespace kerf {

struct ProcessUsage {
  double cpu_s = 0.0;               // s, of all threads since the process started
  std::int64_t resident_bytes = 0;  // physical memory that the process occupies
};

// Reads the usage of the process with this id from /proc. Returns nothing if there is no such process.
[[nodiscard]] std::optional<ProcessUsage> usage_of(std::int64_t pid);
// Reads the usage of this process.
[[nodiscard]] ProcessUsage own_usage();
// Returns the bytes of physical memory that this process occupies, or 0 if /proc does not say.
[[nodiscard]] std::int64_t resident_bytes();

}  // namespace kerf
