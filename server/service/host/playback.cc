#include "server/service/host/playback.h"

#include <utility>

namespace kerf::host {

Error replaying() {
  return failed_precondition(
      "REPLAYING", "the sheet plays a recording and takes no commands until that ends; delete the sheet to end it now");
}

Playback::Playback(std::vector<sheet::RecordedTick> entries, std::int64_t torn_bytes) : entries_(std::move(entries)) {
  status_.torn_bytes = torn_bytes;
  if (entries_.empty()) {
    status_.state = ReplayState::kDone;
  } else {
    status_.end_tick = entries_.back().tick;
  }
}

const sheet::RecordedTick* Playback::next_at(std::int64_t tick) const {
  return is_playing() && entries_[next_].tick == tick ? &entries_[next_] : nullptr;
}

void Playback::passed(std::int64_t tick, std::uint64_t state_hash) {
  if (entries_[next_].tick != tick || entries_[next_].state_hash != state_hash) {
    diverge(tick, state_hash);
  } else if (++next_ == entries_.size()) {
    status_.state = ReplayState::kDone;
  }
}

void Playback::stuck(std::int64_t tick, std::uint64_t state_hash) {
  diverge(tick, state_hash);
}

void Playback::diverge(std::int64_t tick, std::uint64_t state_hash) {
  const sheet::RecordedTick& entry = entries_[next_];
  status_.divergence = sheet::Divergence{next_, entry.tick, entry.state_hash, state_hash, tick};
  status_.state = ReplayState::kDiverged;
}

}  // namespace kerf::host
