#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "server/base/result.h"

// The format of Sheet::save(). All numbers are little-endian:
//   header    SavedHeader, field by field, then the CRC-32C of these bytes (4 bytes)
//   sections  one after another: number (4 bytes, from 0), length (8), CRC-32C (4), and so many bytes. The CRC is that
//   of
//             the bytes, combined by exclusive or with that of number and length
// Sections hold the members of the sheet in the order of saved_sections(), lists with their length (8 bytes) before
// them. Whatever is derived from them, and the scene, is not there.
namespace kerf::sheet {

struct SavedHeader {
  static constexpr std::array<char, 8> kMagic{'K', 'E', 'R', 'F', 'S', 'A', 'V', 'E'};
  static constexpr std::uint32_t kFormat = 1;

  std::array<char, 8> magic = kMagic;
  std::uint32_t format = kFormat;
  std::uint32_t num_sections = 0;
  std::uint64_t engine = 0;             // engine_hash() of the build that wrote it
  std::uint64_t scene = 0;              // hash of the sheet as its scene made it
  std::int64_t tick = 0;                // Sheet::tick()
  std::uint64_t state_hash = 0;         // Sheet::state_hash()
  std::uint64_t continuation_hash = 0;  // Sheet::continuation_hash()
};

// Reads and checks the header alone. Errors: as of Sheet::load().
Result<SavedHeader> read_saved_header(std::string_view saved);

// Returns a hash of what this build computes: of small sheets after some ticks. Builds with equal hashes give equal
// bits, as far as these sheets show. The first call takes some 20 ms.
std::uint64_t engine_hash();

}  // namespace kerf::sheet
