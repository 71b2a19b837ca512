#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Codes small integers in few bits: in blocks of Rice codes, each with its own parameter. (R. F. Rice, "Some practical
// universal noiseless coding techniques", JPL 79-22, 1979.) Differences between predicted and actual values are mostly
// small, and their size varies along a sheet. A block adapts to that without a table to be sent.
//
// Rows of `columns` numbers are cut into blocks of kBlockRows rows. For each column, a block has 5 bits k and then the
// column's numbers u:
//   k = 31      every number is 0, and no more bits follow
//   k = 0..30   each is u >> k in unary (that many ones, then a zero), then the low k bits of u;
//               where u >> k is kEscape or more: kEscape ones, then all 32 bits of u
// Bits fill each byte from the lowest up. Numbers begin with their lowest bit, and zeros fill the last byte.
namespace kerf::codec {

inline constexpr int kBlockRows = 16;
inline constexpr int kParameterBits = 5;
inline constexpr std::uint32_t kAllZero = 31;
inline constexpr int kEscape = 16;

// Maps signed numbers to unsigned ones of about twice the size: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
constexpr std::uint32_t zigzag(std::int32_t value) {
  return (static_cast<std::uint32_t>(value) << 1) ^ static_cast<std::uint32_t>(value >> 31);
}
constexpr std::int32_t unzigzag(std::uint32_t value) {
  return static_cast<std::int32_t>((value >> 1) ^ (0U - (value & 1U)));
}

// Packs `values`, rows of `columns` numbers stored consecutively. `columns` is > 0 and divides their count.
std::string pack_integers(std::span<const std::uint32_t> values, std::size_t columns);

// Returns `count` numbers (a multiple of columns > 0). Returns nothing if the bytes are not exactly those that
// pack_integers() makes of that many numbers. Never reads outside `bytes`; allocates for `count` only if the bytes can
// hold that many.
std::optional<std::vector<std::uint32_t>> unpack_integers(std::string_view bytes, std::size_t count,
                                                          std::size_t columns);

}  // namespace kerf::codec
