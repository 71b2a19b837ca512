#pragma once

#include <cstdint>

namespace kerf::app {

struct ConnectionLimits {
  int grpc = 0;
  int http = 0;
};

// Returns the number of connections that each transport may have open, at least 4. Thus neither transport takes the
// descriptors of the other, of files or of recordings. `descriptors`: the limit of the process. `in_use`: number of
// descriptors open already. `recordings`: number of recording files that may be open.
ConnectionLimits connection_limits(std::int64_t descriptors, std::int64_t in_use, std::int64_t recordings);

}  // namespace kerf::app
