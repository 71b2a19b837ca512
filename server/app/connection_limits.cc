#include "server/app/connection_limits.h"

#include <algorithm>

namespace kerf::app {

ConnectionLimits connection_limits(std::int64_t descriptors, std::int64_t in_use, std::int64_t recordings) {
  constexpr std::int64_t kMostGrpc = 10'000;
  constexpr std::int64_t kMostHttp = 1'000;
  constexpr std::int64_t kLeast = 4;
  constexpr std::int64_t kFiles = 16;  // Scenes and meshes being read, files opened by libraries, /proc.
  const std::int64_t free = descriptors - in_use - recordings - kFiles;
  const std::int64_t http = std::clamp(free / 2, kLeast, kMostHttp);
  return {static_cast<int>(std::clamp(free - http, kLeast, kMostGrpc)), static_cast<int>(http)};
}

}  // namespace kerf::app
