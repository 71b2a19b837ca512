#pragma once

#include <cstdint>
#include <filesystem>

namespace kerf {

// Returns the bytes that this process may use; 0 if unknown. This is the least of the machine's memory, the address
// space limit and the limits of its control groups. Reads cgroups of versions 1 and 2, as in containers. `root`:
// directory that holds proc/ and sys/.
std::int64_t memory_limit(const std::filesystem::path& root = "/");

}  // namespace kerf
