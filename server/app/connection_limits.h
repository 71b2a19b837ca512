#pragma once

#include <cstdint>

namespace kerf::app {

struct ConnectionLimits {
  int grpc = 0;
  int http = 0;
};

// Returns the number of connections that each transport may have open, so that neither takes the descriptors of the
// other, of files or of recordings. `descriptors`: the process's limit; `in_use` and `recordings` are reserved for
// others. At least 4 of each.
ConnectionLimits connection_limits(std::int64_t descriptors, std::int64_t in_use, std::int64_t recordings);

}  // namespace kerf::app
