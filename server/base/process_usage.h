#pragma once

#include <cstdint>
#include <optional>

namespace kerf {

struct ProcessUsage {
  double cpu_s = 0.0;               // s, of all its threads since it began
  std::int64_t resident_bytes = 0;  // memory
};

// Reads the usage of a process of this machine from /proc; nothing if no process has that id.
[[nodiscard]] std::optional<ProcessUsage> usage_of(std::int64_t pid);
// Reads the usage of this process.
[[nodiscard]] ProcessUsage own_usage();
// Returns the bytes of memory that this process has; 0 if /proc does not say.
[[nodiscard]] std::int64_t resident_bytes();

}  // namespace kerf
