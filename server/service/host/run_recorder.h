#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/recording.h"
#include "server/service/host/kept_recording.h"

namespace kerf::host {

// Records the run of one sheet twice: in memory, see KeptRecording, and to a sink, such as a file, if one was given.
// Hashes are passed as functions, since they cost time and are seldom needed. Each tick is recorded in three calls:
//
//   prepare(), if it may become an apply()    before the tick
//   settle()                                  after it
//   append(), if a recording can express it   after settle()
//
// For one thread at a time.
class RunRecorder {
 public:
  explicit RunRecorder(KeptRecording kept) : kept_(std::move(kept)) {}

  // Starts recording to `sink`; null: in memory only.
  void begin(std::shared_ptr<sheet::RecordingSink> sink, const scene::SheetConfig& config);
  // Releases the sink.
  void end() { sink_.reset(); }

  // Remembers an entry of the sheet's state at `tick`, unless the recording in memory has reached `tick` already. See
  // KeptRecording::lags().
  template <typename Hash>
  void prepare(std::int64_t tick, Hash state_hash) {
    if (kept_.lags(tick)) bare_ = sheet::RecordedTick{tick, {}, state_hash()};
  }
  // Appends the remembered entry in memory if the tick was an apply(), in which time stands still. Forgets it in any
  // case.
  void settle(bool was_apply);
  // Sets the hash of an entry, and appends the entry in memory if it is wanted there, and to the sink if there is one.
  template <typename Hash>
  void append(sheet::RecordedTick& entry, Hash state_hash) {
    const bool is_kept = kept_.wants(entry.tick, !entry.commands.empty());
    if (!is_kept && !sink_) return;
    entry.state_hash = state_hash();
    if (is_kept) kept_.append(entry);
    if (sink_) sink_->append(entry);
  }

  [[nodiscard]] const KeptEntries& kept() const { return kept_.entries(); }
  // Continues after these entries in memory. Ends the recording to the sink, which they do not continue, and says why.
  void replace(KeptEntries kept, const std::string& why);

  // Returns the entries kept in memory, see KeptRecording::until().
  [[nodiscard]] Result<std::string> until(std::int64_t tick, std::uint64_t state_hash) const {
    return kept_.until(tick, state_hash);
  }

 private:
  KeptRecording kept_;
  std::shared_ptr<sheet::RecordingSink> sink_;
  std::optional<sheet::RecordedTick> bare_;  // Entry without commands that prepare() has remembered.
};

}  // namespace kerf::host
