#pragma once

#include <cstdint>

namespace kerf {

// Raises this process's limit of open files and connections as far as the system lets it. Returns the limit.
std::int64_t raise_descriptor_limit();
// Files and connections that this process has open.
[[nodiscard]] std::int64_t num_open_descriptors();

}  // namespace kerf
