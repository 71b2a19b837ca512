#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "server/base/result.h"
#include "server/core/sheet/recording.h"

namespace kerf::host {

// Holds what a KeptRecording has kept. A plain value.
struct KeptEntries {
  std::string bytes;              // Results of the encoder, concatenated; empty if the recording was dropped.
  std::int64_t last_tick = 0;     // Tick of the last entry.
  std::int64_t given_up_at = -1;  // Tick at which the recording was dropped; -1: it is not dropped.
};

// Keeps an encoded recording of a live sheet's run in memory. It has an entry for every kHashInterval-th tick, and for
// each tick with commands other than the scene's own. Beyond `max_bytes` the whole recording is dropped, because one
// with a gap cannot be replayed.
class KeptRecording {
 public:
  static constexpr std::int64_t kHashInterval = 64;  // ticks
  using Encoder = std::function<std::string(const sheet::RecordedTick&)>;

  // `encode`: null keeps nothing.
  KeptRecording(Encoder encode, std::size_t max_bytes) : encode_(std::move(encode)), max_bytes_(max_bytes) {}

  // True if the recording needs an entry for a Sheet::step() that ended at `tick`, or for a Sheet::apply() at `tick`.
  [[nodiscard]] bool wants(std::int64_t tick, bool has_commands) const {
    return is_kept() && (has_commands || (tick % kHashInterval == 0 && tick > entries_.last_tick));
  }
  // True if no entry has reached `tick` yet. An entry of an apply() at `tick` must then follow an entry of `tick`
  // without commands: a replay takes the first entry of a tick for a step().
  [[nodiscard]] bool lags(std::int64_t tick) const { return is_kept() && tick > entries_.last_tick; }
  void append(const sheet::RecordedTick& entry);

  // Returns all entries, up to the sheet's present `tick`. If the last entry is earlier, an entry of `tick` without
  // commands is added. kFailedPrecondition RECORDING_NOT_KEPT, RECORDING_TOO_LONG.
  [[nodiscard]] Result<std::string> until(std::int64_t tick, std::uint64_t state_hash) const;

  [[nodiscard]] const KeptEntries& entries() const { return entries_; }
  // Continues after these entries, which a KeptRecording with an equal encoder has kept.
  void replace(KeptEntries entries) { entries_ = std::move(entries); }

 private:
  [[nodiscard]] bool is_kept() const { return encode_ && entries_.given_up_at < 0; }

  Encoder encode_;
  std::size_t max_bytes_;
  KeptEntries entries_;
};

}  // namespace kerf::host
