#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/sheet.h"

// A run as (tick, commands, hash): bug report, regression test and journal in one.
namespace kerf::sheet {

inline constexpr std::int64_t kMaxRecordedGap = 4096;  // ticks from one entry to the next
inline constexpr std::size_t kMaxTickCommands = 256;   // of an entry; a live tick does not get that many

// One step() or apply(). An entry with the same tick as the entry before it (0 before the first) was an apply() of
// commands. A step of a frozen sheet with commands is recorded in the same way. Ticks between two entries were steps
// without commands from outside.
struct RecordedTick {
  std::int64_t tick = 0;          // after it
  std::vector<Command> commands;  // that came from outside, in order; the config's own are not repeated
  std::uint64_t state_hash = 0;   // after it
};

struct Recording {
  SheetConfig config;
  std::vector<RecordedTick> entries;
  std::int64_t torn_bytes = 0;  // at its file's end, of an entry that is not there as a whole and was left out
};

// Receives a recording while it is made. Called from the sheet's strand, in order.
class RecordingSink {
 public:
  virtual ~RecordingSink() = default;
  virtual void start(const SheetConfig& config) = 0;
  virtual void append(const RecordedTick& entry) = 0;
};

// Keeps a recording in memory.
class Recorder : public RecordingSink {
 public:
  void start(const SheetConfig& config) override;
  void append(const RecordedTick& entry) override;

  [[nodiscard]] const Recording& recording() const { return recording_; }

 private:
  Recording recording_;
};

struct Divergence {
  std::size_t entry = 0;  // index into Recording::entries
  std::int64_t tick = 0;  // recorded
  std::uint64_t recorded_hash = 0;
  std::uint64_t replayed_hash = 0;
  std::int64_t replayed_tick = 0;  // differs from `tick` where the recording cannot have come from this config
};

struct ReplayReport {
  std::int64_t ticks = 0;                // replayed
  std::optional<Divergence> divergence;  // the first; empty: equal bit for bit
};

// Checks that `entry`, number `index`, may follow an entry of tick `before`; 0 before the first. Errors, kDataLoss:
// RECORDING_ORDER if the tick goes back, skips more than kMaxRecordedGap or repeats without any command; RECORDING_TICK
// if it has more than kMaxTickCommands.
Status check_next(const RecordedTick& entry, std::size_t index, std::int64_t before);

// Checks all entries.
Status check_order(std::span<const RecordedTick> entries);

// Rebuilds the sheet, gives it the same commands at the same ticks and compares every hash; stops at the first that
// differs. Errors: those of Sheet::create and check_order().
Result<ReplayReport> replay(const Recording& recording);

}  // namespace kerf::sheet
