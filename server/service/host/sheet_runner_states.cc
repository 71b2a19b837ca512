#include <cstdint>
#include <string_view>
#include <utility>

#include "server/base/catch_exceptions.h"
#include "server/base/memory_headroom.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/service/host/playback.h"
#include "server/service/host/sheet_runner.h"

// Saves the run of a SheetRunner, and continues from a saved one.
namespace kerf::host {

namespace {

// Bytes per vertex that must be free to save a run, or to publish a restored one; 200 and more with undo are taken.
constexpr std::int64_t kBytesPerSavedVertex = 1000;

}  // namespace

Status SheetRunner::check_between_runs() const {
  if (is_playing()) return replaying();
  if (step_call_) return failed_precondition("STEPPING", "the sheet is being stepped; try again when that is done");
  return Nothing{};
}

Result<SavedRun> SheetRunner::save_run() const {
  KERF_TRY(check_between_runs());
  if (!has_memory_for(kBytesPerSavedVertex * sheet_.mesh().num_vertices())) return out_of_memory();
  std::string bytes;
  sheet_.save([&](std::string_view part) { bytes += part; });
  bytes.shrink_to_fit();
  SavedRun run;
  run.sheet = std::make_shared<const std::string>(std::move(bytes));
  run.scheduled = queue_.scheduled();
  run.last_schedule_number = queue_.last_number();
  run.changes = changes_;
  run.flagged_ticks = flagged_ticks_;
  run.recording = recorder_.kept();
  run.paused = clock_.is_paused();
  run.speed = clock_.pace().speed();
  return run;
}

Status SheetRunner::continue_from(const SavedRun& run, sheet::Sheet sheet, std::uint64_t serial) {
  KERF_TRY(check_between_runs());
  // Copied first, so that a lack of memory leaves the sheet as it is.
  std::vector<ScheduledCommand> scheduled = run.scheduled;
  KeptEntries recording = run.recording;
  if (!has_memory_for(kBytesPerSavedVertex * sheet.mesh().num_vertices())) return out_of_memory();
  stop_clock();
  // Settings of different serials differ for viewers, and the version must not fall.
  state_changes_ += sheet_.settings_version() - sheet.settings_version() + 1;
  sheet_ = std::move(sheet);
  serial_ = serial;
  queue_.replace_scheduled(std::move(scheduled), run.last_schedule_number);
  changes_ = run.changes;
  flagged_ticks_ = run.flagged_ticks;
  recorder_.replace(std::move(recording), "the sheet went back to a saved state, which a recording cannot express");
  last_step_ = {};
  repeats_now_ = false;
  metrics_.continue_from(totals());
  if (clock_.is_sleeping()) clock_.wake();
  publish_state();
  publish_status();
  if (run_state() == RunState::kRunning) start_clock();
  publish();
  return Nothing{};
}

}  // namespace kerf::host
