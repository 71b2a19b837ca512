#include <cstdint>
#include <string_view>
#include <utility>

#include "server/base/catch_exceptions.h"
#include "server/base/memory_headroom.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/saved_sheet.h"
#include "server/service/host/playback.h"
#include "server/service/host/sheet_runner.h"

// Saves the run of a SheetRunner, and continues from a saved one.
namespace kerf::host {

namespace {

constexpr std::size_t kUsualBytesPerSavedVertex = 200;  // without what undo needs

}  // namespace

Status SheetRunner::check_between_runs() const {
  if (is_playing()) return replaying();
  if (step_call_) return failed_precondition("STEPPING", "the sheet is being stepped; try again when that is done");
  return Nothing{};
}

Result<SavedState> SheetRunner::save_state(std::string state_id) const {
  KERF_TRY(check_between_runs());
  if (!has_memory_for(kBytesPerSavedVertex * sheet_.mesh().num_vertices())) return out_of_memory();
  return make_state(std::move(state_id));
}

SavedState SheetRunner::make_state(std::string state_id) const {
  std::string bytes;
  bytes.reserve(kUsualBytesPerSavedVertex * static_cast<std::size_t>(sheet_.mesh().num_vertices()));
  sheet_.save([&](std::string_view part) { bytes += part; });
  if (!state_id.empty()) bytes.shrink_to_fit();  // Others are gone once they are stored.
  SavedState state;
  SavedRun& run = state.run;
  run.sheet = std::make_shared<const std::string>(std::move(bytes));
  run.scheduled = queue_.scheduled();
  run.last_schedule_number = queue_.last_number();
  run.changes = changes_;
  run.flagged_ticks = flagged_ticks_;
  run.recording = recorder_.kept();
  run.paused = clock_.is_paused();
  run.speed = clock_.pace().speed();
  const auto attachments = context_.attachments.get();
  if (attachments && attachments->save) run.attachment = attachments->save(id_);
  const sheet::SavedHeader header = sheet::read_saved_header(*run.sheet).value();
  state.status.id = std::move(state_id);
  state.status.tick = header.tick;
  state.status.scene_tick = sheet_.scene_tick();
  state.status.num_vertices = sheet_.mesh().num_vertices();
  state.status.num_bytes = static_cast<std::int64_t>(run.num_bytes());
  state.status.state_hash = header.state_hash;
  state.status.continuation_hash = header.continuation_hash;
  state.status.saved_unix_us = context_.clock.unix_us();
  state.config = sheet_.shared_config();
  return state;
}

void SheetRunner::store_named(const std::shared_ptr<const SavedState>& state, const Callback<SavedStateStatus>& done) {
  if (!journal_.is_on()) return done(state->status);
  journal_.save_named(stored(state), [status = state->status, done](const Status& saved) {
    if (!saved.ok()) return done(saved.error());
    done(status);
  });
}

void SheetRunner::remove_named(const std::string& state_id, const Callback<Nothing>& done) {
  if (!journal_.is_on()) return done(Nothing{});
  journal_.remove_named(state_id, done);
}

Status SheetRunner::continue_from(const SavedRun& run, sheet::Sheet sheet, std::uint64_t serial,
                                  const RequestName<SheetStatus>& request) {
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
  const auto attachments = context_.attachments.get();
  if (attachments && attachments->load) attachments->load(id_, run.attachment);
  if (journal_.is_on()) {
    journal_.write_restore(sheet_.tick(), sheet_.state_hash(),
                           stored(std::make_shared<const SavedState>(make_state(""))),
                           journal_.answered(request, status()));
  }
  if (clock_.is_sleeping()) clock_.wake();
  publish_state();
  publish_status();
  if (run_state() == RunState::kRunning) start_clock();
  publish();
  return Nothing{};
}

}  // namespace kerf::host
