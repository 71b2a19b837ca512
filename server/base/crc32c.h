#pragma once

#include <cstdint>
#include <string_view>

namespace kerf {

// Returns the CRC-32C (Castagnoli, RFC 3720) of `bytes`. It detects every single flipped bit, and every burst of errors
// of up to 32 bits.
std::uint32_t crc32c(std::string_view bytes);

}  // namespace kerf
