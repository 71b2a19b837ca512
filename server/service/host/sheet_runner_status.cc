#include <memory>
#include <utility>

#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/sheet_materials.h"
#include "server/service/host/sheet_runner.h"

#include <algorithm>

// Describes a SheetRunner's sheet to callers, sinks and the last status.
namespace kerf::host {

void SheetRunner::publish_to(sheet::SnapshotSink& sink) {
  if (!sink.wants_snapshot()) return;
  metrics_.snapshot_built();
  std::shared_ptr<sheet::Snapshot> snapshot = sheet_.snapshot(run_stats(), sink.wants_strains());
  sink.measure(sheet_, *snapshot);
  if (journal_.holds_back()) return hold_back(std::move(snapshot));
  if (journal_.is_on()) shown_ = snapshot;
  sink.publish(std::move(snapshot));
}

void SheetRunner::publish() {
  if (!sinks_.want_snapshot()) return;
  std::shared_ptr<sheet::Snapshot> snapshot = sheet_.snapshot(run_stats(), sinks_.want_strains());
  sinks_.measure(sheet_, *snapshot);
  metrics_.snapshot_built();
  if (journal_.holds_back()) return hold_back(std::move(snapshot));
  show(std::move(snapshot));
}

void SheetRunner::show(std::shared_ptr<const sheet::Snapshot> snapshot) {
  if (journal_.is_on()) shown_ = snapshot;
  sinks_.publish(snapshot);
}

Result<KeptRun> SheetRunner::kept_run() const {
  KERF_TRY_ASSIGN(std::string entries, recorder_.until(sheet_.tick(), sheet_.state_hash()));
  return KeptRun{sheet_.shared_config(), std::move(entries)};
}

SheetStatus SheetRunner::status() const {
  SheetStatus status = unhashed_status();
  status.state_hash = sheet_.state_hash();
  return status;
}

SheetStatus SheetRunner::unhashed_status() const {
  SheetStatus status;
  status.id = id_;
  status.created_unix_us = created_unix_us_;
  status.resimulated_from_tick = resimulated_from_tick_;
  status.run_state = run_state();
  status.tick = sheet_.tick();
  status.scene_tick = sheet_.scene_tick();
  status.viewers = sinks_.num_viewers();
  status.topology_version = sheet_.topology_version();
  status.num_vertices = sheet_.mesh().num_vertices();
  status.num_triangles = sheet_.mesh().num_solid_triangles();
  status.pieces = sheet_.mesh().num_pieces();
  status.stats = run_stats();
  status.pinned_vertices = sheet_.pinned_vertices();
  status.gravity = sheet_.gravity();
  status.wind = sheet_.wind();
  status.self_contact = sheet_.self_contact();
  status.materials = sheet_.materials().entries;
  status.config = sheet_.shared_config();
  status.components = sheet_.components();
  status.mesh_notes = sheet_.mesh_notes();
  status.integrator = sheet_.integrator_description();
  status.softening = sheet_.softening();
  status.local_inertia = sheet_.local_inertia();
  status.tick_estimate = tick_estimate();
  status.linear_iterations = last_step_.linear_iterations;
  status.linear_residual = last_step_.linear_residual;
  status.flagged_ticks = flagged_ticks_;
  if (playback_) status.replay = playback_->status();
  return status;
}

// Counts and publishes the run state if it has changed.
void SheetRunner::publish_state() {
  const bool was_begun = metrics_.is_begun();
  if (!metrics_.set_state(run_state())) return;
  if (was_begun) ++state_changes_;
  publish_status();
}

void SheetRunner::publish_status() {
  SheetStatus status = unhashed_status();
  reached_tick_ = status.tick;
  share_->set_vertices(status.num_vertices);
  share_->set_need(metrics_.counted_need());
  if (journal_.holds_back()) return held_status_.add(journal_.last_edit(), std::move(status));
  last_status_.set(std::move(status));
}

std::int64_t SheetRunner::need_at(double speed) const {
  const double need = static_cast<double>(metrics_.need()) * speed / clock_.pace().speed();
  return std::min(static_cast<std::int64_t>(need), WorkerNeed::kWhole);
}

RunState SheetRunner::run_state() const {
  if (sheet_.frozen()) return RunState::kFailed;
  if (clock_.is_paused()) return RunState::kPaused;
  return clock_.is_sleeping() ? RunState::kSleeping : RunState::kRunning;
}

sheet::RunStats SheetRunner::run_stats() const {
  sheet::RunStats stats;
  const RunState state = run_state();
  const bool stands = state == RunState::kPaused || state == RunState::kFailed;
  stats.real_time_factor = stands ? 0.0 : clock_.pace().real_time_factor();
  stats.speed = clock_.pace().speed();
  stats.overruns = clock_.pace().overruns();
  stats.slipped_s = seconds(clock_.pace().slipped());
  stats.tick_cpu_us = clock_.pace().tick_cpu_us();
  stats.published_unix_us = context_.clock.unix_us();
  stats.sheet_serial = serial_;
  stats.settings_version = sheet_.settings_version() + state_changes_;
  stats.strained_share = last_step_.strained_share;
  stats.intersections = last_step_.self_contact.intersections;
  stats.resets = changes_.resets();
  stats.resets_undone = changes_.resets_undone();
  stats.paused = clock_.is_paused();
  stats.sleeping = clock_.is_sleeping();
  stats.failed = sheet_.frozen();
  return stats;
}

}  // namespace kerf::host
