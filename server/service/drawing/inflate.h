#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "server/base/result.h"

namespace kerf::drawing {

// Most bytes of a drawing after it was decompressed.
inline constexpr std::size_t kMaxInflatedBytes = std::size_t{16} << 20;

bool is_gzip(std::string_view data);
// Decompresses what gzip compressed, also of several members. Errors: kInvalidArgument, `kind`_MALFORMED and
// `kind`_TOO_LARGE with the field `field`.
Result<std::string> inflated(std::string_view data, const std::string& kind, const std::string& field);

// Compresses as gzip does.
std::string gzipped(std::string_view data);

}  // namespace kerf::drawing
