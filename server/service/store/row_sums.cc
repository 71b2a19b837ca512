#include "server/service/store/row_sums.h"

#include <algorithm>

#include "server/base/crc32c.h"

namespace kerf::store {

RowSum& RowSum::add(std::int64_t value) {
  for (unsigned shift = 0; shift < 64; shift += 8) {
    fields_.push_back(static_cast<char>((static_cast<std::uint64_t>(value) >> shift) & 0xffU));
  }
  return *this;
}

RowSum& RowSum::add(std::string_view bytes) {
  add(static_cast<std::int64_t>(bytes.size()));
  fields_.append(bytes);
  return *this;
}

std::int64_t RowSum::value() const {
  return crc32c(fields_);
}

std::int64_t row_sum(const host::JournalEntry& entry) {
  return RowSum()
      .add(entry.sheet)
      .add(entry.seq)
      .add(entry.tick)
      .add(static_cast<std::int64_t>(entry.state_hash))
      .add(entry.content)
      .value();
}

std::int64_t row_sum(const host::StoredRequest& request, std::int64_t sheet, std::int64_t seq,
                     std::int64_t at_unix_us) {
  return RowSum()
      .add(request.key)
      .add(static_cast<std::int64_t>(request.body_hash))
      .add(request.reply)
      .add(sheet)
      .add(seq)
      .add(at_unix_us)
      .value();
}

std::int64_t row_sum(const StateInfo& state) {
  return RowSum()
      .add(state.sheet)
      .add(state.seq)
      .add(state.name)
      .add(state.number)
      .add(state.tick)
      .add(static_cast<std::int64_t>(state.engine))
      .add(static_cast<std::int64_t>(state.state_hash))
      .add(static_cast<std::int64_t>(state.continuation_hash))
      .add(state.bytes)
      .add(static_cast<std::int64_t>(state.content_sum))
      .value();
}

void PieceSums::add(std::string_view piece) {
  sums_.add(static_cast<std::int64_t>(crc32c(piece)));
}

std::uint32_t PieceSums::value() const {
  return static_cast<std::uint32_t>(sums_.value());
}

std::uint32_t content_sum(std::string_view content) {
  PieceSums sums;
  for (std::size_t at = 0; at < content.size(); at += kPieceBytes) sums.add(content.substr(at, kPieceBytes));
  return sums.value();
}

}  // namespace kerf::store
