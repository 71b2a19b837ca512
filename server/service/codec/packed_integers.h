#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Small integers in few bits: blocks of Rice codes whose parameter each block chooses (R. F. Rice, "Some practical
// universal noiseless coding techniques", JPL 79-22, 1979). Differences between what a viewer can foretell and what it
// gets are mostly small, how small varies along a sheet, and a block adapts to that without a table to be sent.
//
// Rows of `columns` numbers are cut into blocks of kBlockRows rows. A block has, column by column, 5 bits k and then
// the column's numbers u:
//   k = 31      every number is 0, and no more bits follow
//   k = 0..30   each is u >> k in unary (that many ones, then a zero), then the low k bits of u;
//               where u >> k is kEscape or more: kEscape ones, then all 32 bits of u
// Bits are filled into bytes from the lowest up, numbers with their lowest bit first, and the last byte with zeros.
namespace kerf::codec {

inline constexpr int kBlockRows = 16;
inline constexpr int kParameterBits = 5;
inline constexpr std::uint32_t kAllZero = 31;
inline constexpr int kEscape = 16;

// Signed numbers as unsigned ones of about twice the size: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
constexpr std::uint32_t zigzag(std::int32_t value) {
  return (static_cast<std::uint32_t>(value) << 1) ^ static_cast<std::uint32_t>(value >> 31);
}
constexpr std::int32_t unzigzag(std::uint32_t value) {
  return static_cast<std::int32_t>((value >> 1) ^ (0U - (value & 1U)));
}

// `values`: rows of `columns` numbers one behind the other; columns > 0 divides their count.
std::string pack_integers(std::span<const std::uint32_t> values, std::size_t columns);

// `count` numbers (a multiple of columns > 0); nothing where the bytes are not exactly what pack_integers() makes of so
// many. Never reads outside `bytes`, whatever they are; allocates for `count` only where the bytes can hold so many.
std::optional<std::vector<std::uint32_t>> unpack_integers(std::string_view bytes, std::size_t count,
                                                          std::size_t columns);

}  // namespace kerf::codec
