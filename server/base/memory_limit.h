#pragma once

#include <cstdint>
#include <filesystem>

namespace kerf {

// Returns the bytes of memory that this process may use, or 0 if unknown. This is the least of the machine's memory,
// the limit of the address space and the limits of the control groups. Reads cgroups of versions 1 and 2. `root`:
// directory that holds proc/ and sys/, for tests.
std::int64_t memory_limit(const std::filesystem::path& root = "/");

}  // namespace kerf
