#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "server/base/result.h"
#include "server/core/sheet/recording.h"

namespace kerf::host {

// Keeps an encoded recording of a live sheet's run in memory. It has an entry for each tick with commands from outside
// and for every kHashInterval-th tick. The latter are the only cost of a sheet without commands. Beyond `max_bytes` the
// whole recording is dropped, since half of one replays nothing.
class KeptRecording {
 public:
  static constexpr std::int64_t kHashInterval = 64;  // ticks
  using Encoder = std::function<std::string(const sheet::RecordedTick&)>;

  // `encode`: null keeps nothing.
  KeptRecording(Encoder encode, std::size_t max_bytes) : encode_(std::move(encode)), max_bytes_(max_bytes) {}

  // True if a step that ended at `tick`, or an apply there, is an entry.
  [[nodiscard]] bool wants(std::int64_t tick, bool has_commands) const {
    return is_kept() && (has_commands || (tick % kHashInterval == 0 && tick > last_tick_));
  }
  // True if an apply at `tick` needs a bare entry of that tick before it; its tick alone would make it a step.
  [[nodiscard]] bool lags(std::int64_t tick) const { return is_kept() && tick > last_tick_; }
  void append(const sheet::RecordedTick& entry);

  // Returns all entries, and a bare one of the sheet's present `tick` if that is later than the last.
  // kFailedPrecondition RECORDING_NOT_KEPT, RECORDING_TOO_LONG.
  [[nodiscard]] Result<std::string> until(std::int64_t tick, std::uint64_t state_hash) const;

 private:
  [[nodiscard]] bool is_kept() const { return encode_ && given_up_at_ < 0; }

  Encoder encode_;
  std::size_t max_bytes_;
  std::string bytes_;
  std::int64_t last_tick_ = 0;     // Tick of the last entry.
  std::int64_t given_up_at_ = -1;  // Tick at which it was dropped; -1: not dropped.
};

}  // namespace kerf::host
