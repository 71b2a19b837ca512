#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/service/host/journal.h"

namespace kerf::store {

// A state that is stored, without its content.
struct StateInfo {
  std::int64_t sheet = 0;
  std::int64_t seq = 0;     // Number of its last entry; 0: it has none.
  std::string name;         // Empty: unnamed.
  std::int64_t number = 0;  // No other state of the store has it: part of the name of the file.
  std::int64_t tick = 0;
  std::uint64_t engine = 0;
  std::uint64_t state_hash = 0;
  std::uint64_t continuation_hash = 0;
  std::int64_t bytes = 0;         // of the content
  std::uint32_t content_sum = 0;  // CRC-32C of those of the content's pieces, see PieceSums
};

// Sums up the fields of a row, each with its length, in a CRC-32C.
class RowSum {
 public:
  RowSum& add(std::int64_t value);
  RowSum& add(std::string_view bytes);
  [[nodiscard]] std::int64_t value() const;

 private:
  std::string fields_;
};

// Returns the CRC-32C that each row of these tables has.
std::int64_t row_sum(const host::JournalEntry& entry);
std::int64_t row_sum(const host::StoredRequest& request, std::int64_t sheet, std::int64_t seq, std::int64_t at_unix_us);
std::int64_t row_sum(const StateInfo& state);

// Bytes of a state that are written, synced and summed up at a time.
inline constexpr std::size_t kPieceBytes = std::size_t{1} << 20U;

// Sums up the content of a state piece by piece, so that no other write waits for a long time.
class PieceSums {
 public:
  void add(std::string_view piece);
  [[nodiscard]] std::uint32_t value() const;

 private:
  RowSum sums_;
};
std::uint32_t content_sum(std::string_view content);

}  // namespace kerf::store
