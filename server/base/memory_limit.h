#pragma once

#include <cstdint>
#include <filesystem>

namespace kerf {

// Bytes that this process may have: the least of the machine's memory, the limits of its control groups (cgroups of
// version 1 and 2, as containers have) and that of its address space. 0 where nothing says. `root`: where /proc and
// /sys are.
std::int64_t memory_limit(const std::filesystem::path& root = "/");

}  // namespace kerf
