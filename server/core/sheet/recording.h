#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/sheet.h"

// A recording of a run: ticks with their commands and hashes. It serves as bug report, regression test and journal.
namespace kerf::sheet {

inline constexpr std::int64_t kMaxRecordedGap = 4096;  // most ticks from one entry to the next
inline constexpr std::size_t kMaxTickCommands = 256;   // most commands of an entry; a live tick never has so many

// One Sheet::step() or apply(). An entry with the same tick as the one before it (0 before the first) was an apply(),
// or a step of a frozen sheet. Ticks between two entries were steps without commands from outside.
struct RecordedTick {
  std::int64_t tick = 0;  // tick after the step
  std::vector<scene::Command>
      commands;                  // commands from outside, in order; scheduled commands of the config are not repeated
  std::uint64_t state_hash = 0;  // Sheet::state_hash() after the step
};

struct Recording {
  scene::SheetConfig config;
  std::vector<RecordedTick> entries;
  std::int64_t torn_bytes = 0;  // bytes of an incomplete last entry in the file, which was left out
};

// Receives a recording while it is made. The functions are called on the sheet's strand (its queue of work), in order.
class RecordingSink {
 public:
  virtual ~RecordingSink() = default;
  virtual void start(const scene::SheetConfig& config) = 0;
  virtual void append(const RecordedTick& entry) = 0;
  // Called last if the run continues in a way that no recording can express. `why`: a clause that says how.
  virtual void end_early(const std::string& /*why*/) {}
};

// Keeps a recording in memory.
class Recorder : public RecordingSink {
 public:
  void start(const scene::SheetConfig& config) override;
  void append(const RecordedTick& entry) override;

  [[nodiscard]] const Recording& recording() const { return recording_; }

 private:
  Recording recording_;
};

struct Divergence {
  std::size_t entry = 0;  // index into Recording::entries
  std::int64_t tick = 0;  // tick of the entry
  std::uint64_t recorded_hash = 0;
  std::uint64_t replayed_hash = 0;
  std::int64_t replayed_tick = 0;  // differs from `tick` if the recording cannot have come from this config
};

struct ReplayReport {
  std::int64_t ticks = 0;                // number of ticks replayed
  std::optional<Divergence> divergence;  // the first difference; empty: all hashes are equal
};

// Checks that `entry`, number `index`, may follow an entry with tick `before` (0 before the first). Errors, kDataLoss:
// RECORDING_ORDER if the tick decreases, grows by more than kMaxRecordedGap, or stays the same without commands;
// RECORDING_TICK if there are more than kMaxTickCommands commands.
Status check_next(const RecordedTick& entry, std::size_t index, std::int64_t before);

// Checks the order of all entries with check_next().
Status check_order(std::span<const RecordedTick> entries);

// Makes the sheet, repeats the commands at their ticks, and compares every hash; stops at the first difference. Errors:
// those of Sheet::create() and check_order().
Result<ReplayReport> replay(const Recording& recording);

}  // namespace kerf::sheet
