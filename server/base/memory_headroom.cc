#include "server/base/memory_headroom.h"

#include <sys/mman.h>
#include <sys/resource.h>

#include <fstream>
#include <limits>
#include <string>

#include "server/base/memory_limit.h"
#include "server/base/process_usage.h"

namespace kerf {
namespace {

// Returns true if the limit of the address space admits one more block of this size. Tries a mapping, which ignores
// memory that the allocator holds in reserve.
bool has_addresses_for(std::int64_t bytes) {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return true;
  const auto size = static_cast<std::size_t>(bytes);
  void* const probe = mmap(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (probe == MAP_FAILED) return false;
  munmap(probe, size);
  return true;
}

// Returns the available memory of the machine in bytes, or the greatest number if /proc does not say.
std::int64_t available_memory() {
  std::ifstream file("/proc/meminfo");
  std::string name;
  std::string unit;
  for (std::int64_t kib = 0; file >> name >> kib;) {
    if (name == "MemAvailable:") return kib * 1024;
    std::getline(file, unit);
  }
  return std::numeric_limits<std::int64_t>::max();
}

bool is_within_limit(std::int64_t needed) {
  static const std::int64_t limit = memory_limit();
  return (limit == 0 || needed <= limit - resident_bytes()) && has_addresses_for(needed);
}

}  // namespace

bool has_memory_for(std::int64_t bytes) {
  if (bytes > std::numeric_limits<std::int64_t>::max() - kMemoryHeadroom) return false;
  const std::int64_t needed = bytes + kMemoryHeadroom;
  return is_within_limit(needed) && needed <= available_memory();
}

bool is_within_memory_limit() {
  return is_within_limit(kMemoryHeadroom);
}

}  // namespace kerf
