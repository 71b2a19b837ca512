#pragma once

#include <cstdint>

namespace kerf {

// Raises this process's limit of open files and connections as far as the system lets it. Returns the new limit, or 0
// if it cannot be read.
std::int64_t raise_descriptor_limit();
// Returns the number of files and connections that this process has open, or 0 if /proc does not say.
[[nodiscard]] std::int64_t num_open_descriptors();

}  // namespace kerf
