#include "server/base/memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace kerf {
namespace {

constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();

// Returns the limit in bytes that a file gives, or kNone if the file does not exist or says "max".
std::int64_t limit_in(const std::filesystem::path& file) {
  std::int64_t bytes = 0;
  return std::ifstream(file) >> bytes && bytes > 0 ? bytes : kNone;
}

// Returns the least limit of a control group and its ancestors, in bytes. In a container, /sys may show only the
// container's own group, as the top of the tree; so the top is read as well.
std::int64_t limit_of_group(const std::filesystem::path& mount, std::string group, const char* file) {
  std::int64_t least = limit_in(mount / file);
  while (group.size() > 1) {
    least = std::min(least, limit_in(mount / group.substr(1) / file));
    group.erase(group.rfind('/'));
  }
  return least;
}

// Returns the least limit of all control groups of this process, in bytes. A line of /proc/self/cgroup is
// number:controllers:group; version 2 has no controllers (see cgroups(7)).
std::int64_t limit_of_groups(const std::filesystem::path& root) {
  const std::filesystem::path mount = root / "sys/fs/cgroup";
  std::int64_t least = kNone;
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const std::string group = line.substr(second + 1);
    if (!group.starts_with('/')) continue;
    if (controllers == ",,") {
      least = std::min(least, limit_of_group(mount, group, "memory.max"));
    } else if (controllers.find(",memory,") != std::string::npos) {
      least = std::min(least, limit_of_group(mount / "memory", group, "memory.limit_in_bytes"));
    }
  }
  return least;
}

std::int64_t limit_of_addresses() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur >= static_cast<rlim_t>(kNone)) return kNone;
  return static_cast<std::int64_t>(limit.rlim_cur);
}

std::int64_t memory_of_the_machine() {
  const std::int64_t pages = sysconf(_SC_PHYS_PAGES);
  const std::int64_t page = sysconf(_SC_PAGESIZE);
  return pages > 0 && page > 0 ? pages * page : kNone;
}

}  // namespace

std::int64_t memory_limit(const std::filesystem::path& root) {
  const std::int64_t least = std::min({memory_of_the_machine(), limit_of_groups(root), limit_of_addresses()});
  return least == kNone ? 0 : least;
}

}  // namespace kerf
