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
  kDone,      // the recording's end was reached, every hash equal
  kDiverged,  // ended at the first hash that differed
};

// How far a sheet that plays a recording has come.
struct ReplayStatus {
  ReplayState state = ReplayState::kPlaying;
  std::int64_t end_tick = 0;    // of the recording
  std::int64_t torn_bytes = 0;  // see sheet::Recording
  std::optional<sheet::Divergence> divergence;
};

// FAILED_PRECONDITION REPLAYING: the answer to commands for a sheet that plays a recording.
Error replaying();

// A recording being played, entry by entry, by whoever steps the sheet.
class Playback {
 public:
  // Entries in order, see sheet::check_order. `torn_bytes`: see sheet::Recording.
  explicit Playback(std::vector<sheet::RecordedTick> entries, std::int64_t torn_bytes = 0);

  [[nodiscard]] const ReplayStatus& status() const { return status_; }
  [[nodiscard]] bool is_playing() const { return status_.state == ReplayState::kPlaying; }

  // The next entry, where that is an apply() on a sheet at `tick`, or the step() that ends at `tick`; else null.
  [[nodiscard]] const sheet::RecordedTick* next_at(std::int64_t tick) const;
  // That entry was done, and the sheet is at `tick` with this hash. Ends the playback at the last one, or where they
  // differ.
  void passed(std::int64_t tick, std::uint64_t state_hash);
  // The sheet, at `tick`, can go no further, though the recording does.
  void stuck(std::int64_t tick, std::uint64_t state_hash);

 private:
  void diverge(std::int64_t tick, std::uint64_t state_hash);

  std::vector<sheet::RecordedTick> entries_;
  std::size_t next_ = 0;
  ReplayStatus status_;
};

}  // namespace kerf::host
