#include "server/service/host/sheet_runner.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "server/base/caught.h"
#include "server/core/scene/sheet_materials.h"

namespace kerf::host {

namespace {

Nanoseconds expected_tick(const sheet::Sheet& sheet) {
  const double counted = sheet.expected_cost().total();
  return counted > 0.0 ? Nanoseconds(std::llround(counted)) : WorkerNeed::guessed_tick(sheet.mesh().num_vertices());
}

Nanoseconds period_of(const sheet::Sheet& sheet) {
  return Nanoseconds(std::llround(1.0e9 * sheet.dt()));
}

Error host_stopping() {
  return unavailable("HOST_STOPPING", "the server is stopping");
}

std::int32_t& gauge(HostMetrics& metrics, RunState state) {
  switch (state) {
    case RunState::kRunning:
      return metrics.running_sheets;
    case RunState::kPaused:
      return metrics.paused_sheets;
    case RunState::kSleeping:
      return metrics.sleeping_sheets;
    case RunState::kFailed:
      return metrics.failed_sheets;
  }
  check_failed("state", __FILE__, __LINE__, "unknown run state");
}

}  // namespace

SheetRunner::SheetRunner(std::string id, sheet::Sheet sheet, Context context, Workers::Strand strand,
                         std::shared_ptr<VertexShare> vertices)
    : id_(std::move(id)),
      context_(context),
      strand_(std::move(strand)),
      sheet_(std::move(sheet)),
      pace_(period_of(sheet_), context_.slip),
      need_(period_of(sheet_), expected_tick(sheet_)),
      vertices_(std::move(vertices)),
      kept_(context_.options.encode_tick, context_.options.max_recording_bytes) {}

void SheetRunner::post(std::function<void(SheetRunner&)> work, std::function<void(Error)> refuse) {
  const bool posted = strand_.post([self = shared_from_this(), work = std::move(work), refuse] {
    if (self->closed_) return refuse(self->closed_error());
    const Status done = caught([&]() -> Status {
      work(*self);
      return Nothing{};
    });
    if (done.ok()) return;
    refuse(done.error());
    if (self->changing_) self->lose();
  });
  if (!posted) refuse(host_stopping());
}

Status SheetRunner::enqueue(sheet::Command command, Callback<CommandResult>& done) {
  {
    const std::lock_guard lock(queue_mutex_);
    const auto limit = static_cast<std::size_t>(context_.options.max_queued_commands);
    if (queue_.size() >= limit) {
      return resource_exhausted("QUEUE_FULL", "the sheet has " + std::to_string(limit) +
                                                  " commands waiting, its limit; try again after a tick");
    }
    push(std::move(command), std::move(done));
  }
  announce_commands();
  return Nothing{};
}

void SheetRunner::release_grab(std::string grab_id) {
  {
    const std::lock_guard lock(queue_mutex_);
    push(sheet::Release{std::move(grab_id)}, [](const auto&) {});
  }
  announce_commands();
}

void SheetRunner::push(sheet::Command command, Callback<CommandResult> done) {
  context_.board.update([](HostMetrics& m) { ++m.queued_commands; });
  if (std::holds_alternative<sheet::UndoCut>(command) || std::holds_alternative<sheet::Reset>(command)) {
    takes_back_waiting_ = true;
  }
  queue_.push_back({std::move(command), std::move(done), context_.clock.now()});
}

// Posts even to a closed runner: close() empties the queue, and so must every later arrival.
void SheetRunner::announce_commands() {
  if (strand_.post([self = shared_from_this()] { self->keep_or_lose([&] { self->commands_arrived(); }); })) return;
  for (Pending& pending : take_queue()) pending.done(host_stopping());
}

void SheetRunner::lose() {
  if (closed_) return;
  context_.board.update([](HostMetrics& m) { ++m.lost_sheets; });
  close(sheet::SinkEnd::kSheetLost);
  context_.lost(id_);
}

void SheetRunner::begin(bool paused, std::shared_ptr<sheet::RecordingSink> recording,
                        std::unique_ptr<Playback> playback) {
  recording_ = std::move(recording);
  if (recording_) recording_->start(sheet_.config());
  playback_ = std::move(playback);
  paused_ = paused || (playback_ && !playback_->is_playing());
  note_state();
  if (!paused_) start_clock();
}

void SheetRunner::close(sheet::SinkEnd reason) {
  if (closed_) return;
  closed_ = reason;
  // Keeps a callback that runs out of memory from hiding the end from others. Its caller then times out.
  const auto attempt = [](const auto& part) {
    try {
      part();
    } catch (const std::bad_alloc&) {
    }
  };
  stop_clock();
  for (Pending& pending : take_queue()) attempt([&] { pending.done(closed_error()); });
  if (step_call_) attempt([&] { finish_step(closed_error()); });
  context_.board.update([&](HostMetrics& m) {
    if (!noted_state_) return;  // It was never begun.
    --gauge(m, *noted_state_);
    --m.sheets;
    m.sinks -= static_cast<std::int32_t>(sinks_.size());
  });
  for (const auto& sink : sinks_) attempt([&] { sink->ended(reason); });
  sinks_.clear();
  recording_.reset();
  vertices_->set(0);
}

void SheetRunner::post_pause(const Callback<SheetStatus>& done) {
  ++pauses_waiting_;
  post(
      [done](SheetRunner& r) {
        --r.pauses_waiting_;
        r.pause();
        done(r.status());
      },
      [done](Error error) { done(std::move(error)); });  // The sheet is closed.
}

void SheetRunner::pause() {
  if (step_call_) finish_step(status());
  if (paused_) return;
  paused_ = true;
  tick_played_ = false;  // The rest of its tick precedes the next one.
  sleeping_ = false;
  stop_clock();
  note_state();
  commands_arrived();
  publish();
}

Status SheetRunner::resume() {
  if (step_call_) {
    return failed_precondition("STEPPING", "the sheet is being stepped; resume it when that is done");
  }
  if (!paused_) return Nothing{};
  paused_ = false;
  note_state();
  if (!sheet_.frozen()) start_clock();
  publish();
  return Nothing{};
}

Result<std::int64_t> SheetRunner::schedule(sheet::Command command, std::int64_t at_tick) {
  if (is_playing()) return replaying();
  if (at_tick <= sheet_.tick()) {
    return failed_precondition("TICK_PAST",
                               "at_tick is " + std::to_string(at_tick) + "; the sheet has already reached tick " +
                                   std::to_string(sheet_.tick()) + ": give a later one",
                               "at_tick");
  }
  const auto limit = static_cast<std::size_t>(context_.options.max_scheduled_commands);
  if (scheduled_.size() >= limit) {
    return resource_exhausted("TOO_MANY_SCHEDULED",
                              "the sheet has " + std::to_string(limit) +
                                  " commands waiting for their tick, its limit; try again when one is done",
                              "at_tick");
  }
  const auto after = std::upper_bound(
      scheduled_.begin(), scheduled_.end(), at_tick,
      [](std::int64_t tick, const WaitingCommand& waiting) { return tick < waiting.appointment.at_tick; });
  scheduled_.insert(after, {{at_tick, ++num_scheduled_}, std::move(command)});
  if (sleeping_) wake();
  return num_scheduled_;
}

Result<WaitingCommand> SheetRunner::cancel(std::int64_t number) {
  if (number < 1 || number > num_scheduled_) {
    return not_found("SCHEDULED_CUTS_NOT_FOUND",
                     "this sheet has no scheduled call with number " + std::to_string(number));
  }
  const auto found = std::find_if(scheduled_.begin(), scheduled_.end(), [number](const WaitingCommand& waiting) {
    return waiting.appointment.number == number;
  });
  if (found == scheduled_.end()) {
    return failed_precondition(
        "SCHEDULED_CUTS_SETTLED",
        "call " + std::to_string(number) +
            " is no longer waiting: it was applied, refused or cancelled; undo reverts its cuts");
  }
  WaitingCommand cancelled = std::move(*found);
  scheduled_.erase(found);
  return cancelled;
}

void SheetRunner::add_sink(std::shared_ptr<sheet::SnapshotSink> sink) {
  context_.board.update([](HostMetrics& m) { ++m.sinks; });
  sinks_.push_back(std::move(sink));
  publish_to(*sinks_.back());
  repeat_if_over();
}

void SheetRunner::refresh_sink(const std::shared_ptr<sheet::SnapshotSink>& sink) {
  if (std::find(sinks_.begin(), sinks_.end(), sink) != sinks_.end()) publish_to(*sink);
  repeat_if_over();
}

void SheetRunner::publish_to(sheet::SnapshotSink& sink) {
  if (!sink.wants_snapshot()) return;
  context_.board.update([](HostMetrics& m) { ++m.snapshots; });
  sink.publish(sheet_.snapshot(run_stats(), sink.wants_strains()));
}

void SheetRunner::remove_sink(const std::shared_ptr<sheet::SnapshotSink>& sink) {
  const auto found = std::find(sinks_.begin(), sinks_.end(), sink);
  if (found == sinks_.end()) return;
  sinks_.erase(found);
  context_.board.update([](HostMetrics& m) { --m.sinks; });
}

SheetStatus SheetRunner::status() const {
  SheetStatus status = unhashed_status();
  status.state_hash = sheet_.state_hash();
  return status;
}

SheetStatus SheetRunner::unhashed_status() const {
  SheetStatus status;
  status.id = id_;
  status.run_state = run_state();
  status.tick = sheet_.tick();
  status.scene_tick = sheet_.scene_tick();
  for (const auto& sink : sinks_) status.viewers += sink->num_viewers();
  status.topology_version = sheet_.topology_version();
  status.num_vertices = sheet_.mesh().num_vertices();
  status.num_triangles = sheet_.mesh().num_solid_triangles();
  status.pieces = sheet_.mesh().num_pieces();
  status.stats = run_stats();
  status.pinned_vertices = sheet_.pinned_vertices();
  status.gravity = sheet_.gravity();
  status.wind = sheet_.wind();
  status.materials = sheet_.materials().entries;
  status.config = sheet_.shared_config();
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

// Leaves commands of a running sheet to the next deadline, and wakes a sleeping one. Otherwise no tick is to come, so
// they are done now.
void SheetRunner::commands_arrived() {
  if (closed_) {
    for (Pending& pending : take_queue()) pending.done(closed_error());
    return;
  }
  if (is_playing()) {
    for (Pending& pending : take_queue()) pending.done(replaying());
    return;
  }
  if (step_call_) return;  // Its ticks drain the queue.
  if (sleeping_) return wake();
  if (!paused_ && !sheet_.frozen()) return;
  const bool was_frozen = sheet_.frozen();
  if (!run_once(false)) return;
  note_state();
  if (was_frozen && !sheet_.frozen() && !paused_) start_clock();
}

void SheetRunner::on_deadline(std::uint64_t generation) {
  keep_or_lose([&] { tick_at_deadline(generation); });
}

void SheetRunner::tick_at_deadline(std::uint64_t generation) {
  if (closed_ || context_.stopping || generation != generation_) return;
  timer_.reset();
  if (sleeping_) return repeat_if_over();
  if (!run_once(true)) return deadline_call()();
  if (paused_) return;  // A replay has ended.
  if (sheet_.frozen()) {
    stop_clock();
    note_state();
  } else if (sheet_.at_rest() && scheduled_.empty() && !is_playing()) {
    stop_clock();
    sleeping_ = true;
    context_.board.update([](HostMetrics& m) { ++m.sleeps; });
    note_state();
    publish();
    await_repeat();
  } else {
    schedule();
  }
}

void SheetRunner::note_state() {
  const RunState state = run_state();
  if (noted_state_ == state) return;
  context_.board.update([&](HostMetrics& m) {
    if (noted_state_) {
      --gauge(m, *noted_state_);
    } else {
      ++m.sheets;
    }
    ++gauge(m, state);
  });
  if (noted_state_) ++state_changes_;
  noted_state_ = state;
  note_status();
}

void SheetRunner::note_status() {
  auto status = std::make_shared<const SheetStatus>(unhashed_status());
  vertices_->set(status->num_vertices);
  const std::lock_guard lock(status_mutex_);
  last_status_.swap(status);
}

std::shared_ptr<const SheetStatus> SheetRunner::last_status() const {
  const std::lock_guard lock(status_mutex_);
  return last_status_;
}

RunState SheetRunner::run_state() const {
  if (sheet_.frozen()) return RunState::kFailed;
  if (paused_) return RunState::kPaused;
  return sleeping_ ? RunState::kSleeping : RunState::kRunning;
}

sheet::RunStats SheetRunner::run_stats() const {
  sheet::RunStats stats;
  const RunState state = run_state();
  const bool stands = state == RunState::kPaused || state == RunState::kFailed;
  stats.real_time_factor = stands ? 0.0 : pace_.real_time_factor();
  stats.speed = pace_.speed();
  stats.overruns = pace_.overruns();
  stats.slipped_s = seconds(pace_.slipped());
  stats.tick_cpu_us = pace_.tick_cpu_us();
  stats.published_unix_us = context_.clock.unix_us();
  stats.sheet_serial = context_.serial;
  stats.settings_version = sheet_.settings_version() + state_changes_;
  stats.strained_share = last_step_.strained_share;
  stats.resets = resets_;
  stats.resets_undone = resets_undone_;
  stats.paused = paused_;
  stats.sleeping = sleeping_;
  stats.failed = sheet_.frozen();
  return stats;
}

Error SheetRunner::closed_error() const {
  if (closed_ == sheet::SinkEnd::kHostStopping) return host_stopping();
  if (closed_ == sheet::SinkEnd::kSheetLost) {
    return data_loss("SHEET_LOST", "the server had too little memory to keep the sheet \"" + id_ +
                                       "\"; its --record file is complete up to then");
  }
  return aborted("SHEET_DELETED", "the sheet \"" + id_ + "\" was deleted meanwhile");
}

}  // namespace kerf::host
