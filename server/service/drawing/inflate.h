#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "server/base/result.h"

namespace kerf::drawing {

// Most bytes of a drawing after it was decompressed.
inline constexpr std::size_t kMaxInflatedBytes = std::size_t{16} << 20;

bool is_gzip(std::string_view data);
// Decompresses a file that gzip compressed, also of several members. Errors: kInvalidArgument, `kind`_MALFORMED and
// `kind`_TOO_LARGE with the field `field`. A file that is compressed twice is malformed.
Result<std::string> inflated(std::string_view data, const std::string& kind, const std::string& field,
                             std::size_t max_bytes = kMaxInflatedBytes);
// Returns the first `num_bytes` of what inflated() would, or those before a fault.
std::string inflated_start(std::string_view data, std::size_t num_bytes);

// Compresses as gzip does.
std::string gzipped(std::string_view data);

}  // namespace kerf::drawing
