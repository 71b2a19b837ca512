#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "server/base/result.h"
#include "server/core/sheet/recording.h"

namespace kerf::host {

enum class ReplayState {
  kPlaying,
  kDone,      // The recording's end was reached, and every hash was equal.
  kDiverged,  // Ended at the first hash that differed.
};

// Describes the progress of a sheet that plays a recording.
struct ReplayStatus {
  ReplayState state = ReplayState::kPlaying;
  std::int64_t end_tick = 0;    // Last tick of the recording.
  std::int64_t torn_bytes = 0;  // see sheet::Recording
  std::optional<sheet::Divergence> divergence;
};

// Returns FAILED_PRECONDITION REPLAYING, the answer to commands for a sheet that plays a recording.
Error replaying();

// Plays a recording entry by entry; its owner steps the sheet.
class Playback {
 public:
  // `entries`: in order, see sheet::check_order. `torn_bytes`: see sheet::Recording.
  explicit Playback(std::vector<sheet::RecordedTick> entries, std::int64_t torn_bytes = 0);

  [[nodiscard]] const ReplayStatus& status() const { return status_; }
  [[nodiscard]] bool is_playing() const { return status_.state == ReplayState::kPlaying; }

  // Returns the next entry if its tick is `tick`; else null. The entry is an apply() if the sheet is already at `tick`,
  // and a step() if it is one tick before.
  [[nodiscard]] const sheet::RecordedTick* next_at(std::int64_t tick) const;
  // Records that the next entry was done, which left the sheet at `tick` with this hash. Ends the playback after the
  // last entry, or if the hashes differ.
  void passed(std::int64_t tick, std::uint64_t state_hash);
  // Records that the sheet froze at `tick`, before the end of the recording. The playback ends as diverged.
  void stuck(std::int64_t tick, std::uint64_t state_hash);

  // True if the present tick was stepped, and entries to be applied after it may be left.
  [[nodiscard]] bool is_tick_done() const { return is_tick_done_; }
  void tick_done() { is_tick_done_ = true; }
  // Begins the next tick. Entries still to be applied after the present tick then come before the next one.
  void next_tick() { is_tick_done_ = false; }

 private:
  void diverge(std::int64_t tick, std::uint64_t state_hash);

  std::vector<sheet::RecordedTick> entries_;
  std::size_t next_ = 0;
  bool is_tick_done_ = false;
  ReplayStatus status_;
};

}  // namespace kerf::host
