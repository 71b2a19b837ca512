#include "server/service/host/sheet_runner.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/base/catch_exceptions.h"
#include "server/base/memory_headroom.h"
#include "server/core/scene/sheet_materials.h"
#include "server/service/host/errors.h"
#include "server/service/host/host.h"

namespace kerf::host {

namespace {

Nanoseconds expected_tick(const sheet::Sheet& sheet) {
  const double counted = sheet.expected_cost().total();
  return counted > 0.0 ? Nanoseconds(std::llround(counted)) : WorkerNeed::guessed_tick(sheet.mesh().num_vertices());
}

Nanoseconds period_of(const sheet::Sheet& sheet) {
  return Nanoseconds(std::llround(1.0e9 * sheet.dt()));
}

}  // namespace

SheetRunner::SheetRunner(std::string id, sheet::Sheet sheet, Context context, Workers::Strand strand,
                         std::shared_ptr<SheetShare> share)
    : id_(std::move(id)),
      context_(context),
      strand_(std::move(strand)),
      queue_(context_.options.max_queued_commands, context_.options.max_scheduled_commands, context_.board),
      progress_(context_.clock, Host::kLongTick),
      sheet_(std::move(sheet)),
      clock_(period_of(sheet_), context_.slip, context_.clock),
      metrics_(context_.board, WorkerNeed(period_of(sheet_), expected_tick(sheet_))),
      recorder_(KeptRecording(context_.options.encode_tick, context_.options.max_recording_bytes)),
      held_timer_(context_.clock),
      share_(std::move(share)),
      unsaved_(context_.unsaved),
      serial_(context_.serial) {}

void SheetRunner::post(std::function<void(SheetRunner&)> work, std::function<void(Error)> refuse) {
  const bool posted = strand_.post([self = shared_from_this(), work = std::move(work), refuse] {
    if (self->closed_) return refuse(self->closed_error());
    const Status done = catch_exceptions([&]() -> Status {
      work(*self);
      return Nothing{};
    });
    if (done.ok()) return;
    refuse(done.error());
    if (self->changing_) self->lose();
  });
  if (!posted) refuse(host_stopping());
}

Status SheetRunner::enqueue(scene::Command command, Callback<CommandResult>& done, RequestName<CommandResult> request,
                            bool is_of_stream) {
  KERF_TRY(journal_.check_room());
  KERF_TRY(queue_.push(std::move(command), done, context_.clock.now(), std::move(request), is_of_stream));
  announce_commands();
  return Nothing{};
}

void SheetRunner::release_grab(std::string grab_id) {
  queue_.push_release(std::move(grab_id), context_.clock.now());
  announce_commands();
}

// Posts even to a closed runner: close() answers the commands in the queue, but those that arrive later must be
// answered too.
void SheetRunner::announce_commands() {
  if (strand_.post([self = shared_from_this()] { self->keep_or_lose([&] { self->commands_arrived(); }); })) return;
  for (PendingCommand& pending : queue_.take_queued()) pending.done(host_stopping());
}

void SheetRunner::begin(bool paused, std::shared_ptr<sheet::RecordingSink> recording,
                        std::unique_ptr<Playback> playback) {
  created_unix_us_ = context_.clock.unix_us();
  recorder_.begin(std::move(recording), sheet_.config());
  playback_ = std::move(playback);
  // An earlier sheet of this name may have been lost, or replaced.
  const auto attachments = context_.attachments.get();
  if (attachments && attachments->load) attachments->load(id_, {});
  clock_.set_due([weak = weak_from_this(), strand = strand_](std::uint64_t call) {
    strand.post([weak, call] {
      if (const auto self = weak.lock()) self->keep_or_lose([&] { self->tick_at_deadline(call); });
    });
  });
  if (paused || (playback_ && !playback_->is_playing())) clock_.pause();
  publish_state();
  if (!clock_.is_paused()) start_clock();
}

void SheetRunner::lose() {
  if (closed_) return;
  metrics_.lost();
  close(sheet::SinkEnd::kSheetLost);
  context_.lost(id_);
}

void SheetRunner::close(sheet::SinkEnd reason) {
  if (closed_) return;
  closed_ = reason;
  // Keeps a callback that runs out of memory from hiding the end from the other callbacks. The caller of that one times
  // out.
  const auto attempt = [](const auto& part) {
    try {
      part();
    } catch (const std::bad_alloc&) {
    }
  };
  stop_clock();
  held_timer_.stop();
  for (PendingCommand& pending : queue_.take_queued()) attempt([&] { pending.done(closed_error()); });
  if (step_call_) attempt([&] { finish_step(closed_error()); });
  attempt([&] { journal_.give_up(closed_error()); });
  metrics_.end();
  for (const auto& sink : sinks_.take()) attempt([&] { sink->ended(reason); });
  recorder_.end();
  unsaved_.clear();
  share_->give_back();
}

Error SheetRunner::closed_error() const {
  if (closed_ == sheet::SinkEnd::kHostStopping) return host_stopping();
  if (closed_ == sheet::SinkEnd::kSheetLost) {
    return data_loss("SHEET_LOST", "the server had too little memory to keep the sheet \"" + id_ +
                                       "\"; its --record file is complete up to then");
  }
  return aborted("SHEET_DELETED", "the sheet \"" + id_ + "\" was deleted meanwhile");
}

// Leaves commands of a running sheet to the tick at its next deadline, and wakes a sleeping sheet. A paused or frozen
// sheet has no tick to come, so its commands are done now.
void SheetRunner::commands_arrived() {
  if (closed_ || is_ending_) {
    for (PendingCommand& pending : queue_.take_queued()) pending.done(closed_error());
    return;
  }
  if (is_playing()) {
    for (PendingCommand& pending : queue_.take_queued()) pending.done(replaying());
    return;
  }
  if (step_call_) return;  // The ticks of the step() call take the commands.
  if (clock_.is_sleeping()) return wake();
  if (!clock_.is_paused() && !sheet_.frozen()) return;
  const bool was_frozen = sheet_.frozen();
  if (!run_once(false)) return;
  publish_state();
  if (was_frozen && !sheet_.frozen() && !clock_.is_paused()) start_clock();
}

bool SheetRunner::has_room_for(const std::vector<PendingCommand>& queued) const {
  constexpr std::int64_t kBytesPerVertex = 1000;  // At most this much is copied or added by a cut.
  const bool turns_on = std::any_of(queued.begin(), queued.end(), [](const PendingCommand& each) {
    const auto* change = std::get_if<scene::SetSelfContact>(&each.command);
    return change != nullptr && change->is_on.value_or(false);
  });
  const std::int64_t bytes = kBytesPerVertex + (turns_on ? scene::kSelfContactBytes : 0);
  return has_memory_for(bytes * sheet_.mesh().num_vertices());
}

// Keeps releases in the queue, since they need no memory.
void SheetRunner::refuse_for_want_of_memory(std::vector<PendingCommand>& queued) {
  const auto lets_go = [](const PendingCommand& each) { return std::holds_alternative<scene::Release>(each.command); };
  const auto refused = std::stable_partition(queued.begin(), queued.end(), lets_go);
  metrics_.commands_refused(queued.end() - refused);
  for (auto pending = refused; pending != queued.end(); ++pending) pending->done(out_of_memory());
  queued.erase(refused, queued.end());
}

Result<std::int64_t> SheetRunner::schedule(scene::Command command, std::int64_t at_tick,
                                           const RequestName<std::int64_t>& request) {
  if (is_playing()) return replaying();
  KERF_TRY(journal_.check_room());
  ScheduledCommand kept;
  if (journal_.is_on()) kept.command = command;
  Result<std::int64_t> number = queue_.schedule(std::move(command), at_tick, sheet_.tick());
  if (!number.ok()) return number;
  kept.id = {at_tick, *number};
  store(kept, journal_.answered(request, *number));
  if (clock_.is_sleeping()) wake();
  return number;
}

Result<ScheduledCommand> SheetRunner::cancel(std::int64_t number, const RequestName<ScheduledCommand>& request) {
  KERF_TRY(journal_.check_room());
  Result<ScheduledCommand> cancelled = queue_.cancel(number);
  if (cancelled.ok()) store(CancelEvent{number}, journal_.answered(request, *cancelled));
  return cancelled;
}

void SheetRunner::post_pause(const Callback<SheetStatus>& done) {
  ++pauses_waiting_;
  post(
      [done](SheetRunner& r) {
        --r.pauses_waiting_;
        r.pause();
        r.answer<SheetStatus>(done, r.status());
      },
      [done](Error error) { done(std::move(error)); });  // The sheet is closed.
}

void SheetRunner::pause() {
  if (step_call_) finish_step(Nothing{});
  if (clock_.is_paused()) return;
  if (playback_) playback_->next_tick();
  clock_.pause();
  metrics_.stop_ticking();
  store_run_state();
  save_if_due();
  publish_state();
  commands_arrived();
  publish();
}

Status SheetRunner::resume() {
  if (step_call_) {
    return failed_precondition("STEPPING", "the sheet is being stepped; resume it when that is done");
  }
  if (!clock_.is_paused()) return Nothing{};
  clock_.resume();
  store_run_state();
  publish_state();
  if (!sheet_.frozen()) start_clock();
  publish();
  return Nothing{};
}

void SheetRunner::step(std::int64_t ticks, const Callback<SheetStatus>& done, std::stop_token stop) {
  const auto answered = [done](SheetRunner& r, const Status& status) {
    r.answer<SheetStatus>(done, status.ok() ? Result<SheetStatus>(r.status()) : status.error());
  };
  const Status reserved = reserve_step(this, answered, std::move(stop));
  if (!reserved.ok()) return done(reserved.error());
  run_reserved(this, ticks);
}

Status SheetRunner::reserve_step(const void* owner, StepDone done, std::stop_token stop) {
  if (!clock_.is_paused()) {
    return failed_precondition("NOT_PAUSED", "only a paused sheet can be stepped; pause it first");
  }
  if (step_call_) {
    return failed_precondition("STEPPING", "the sheet is already being stepped; wait for that call");
  }
  if (sheet_.frozen()) {
    return failed_precondition("SHEET_FROZEN", "the sheet is frozen at its last good tick; reset it first");
  }
  step_call_ = StepCall{0, std::move(done), std::move(stop), owner, true};
  return Nothing{};
}

void SheetRunner::run_reserved(const void* owner, std::int64_t ticks) {
  if (!step_call_ || step_call_->owner != owner || !step_call_->is_reserved) return;
  step_call_->remaining = ticks;
  step_call_->is_reserved = false;
  // An earlier call may have ended while its next turn was posted. That turn then steps the sheet for this call.
  if (!turn_posted_) keep_or_lose([this] { take_turn(); });
}

void SheetRunner::set_speed(double speed) {
  if (speed == clock_.pace().speed()) return;
  clock_.set_speed(speed);
  metrics_.set_period(clock_.pace().period());
  if (run_state() == RunState::kRunning) {
    clock_.stop();
    metrics_.start_ticking();
    clock_.set_timer();
  }
  ++state_changes_;
  store_run_state();
  publish_status();
  publish();
}

void SheetRunner::start_clock() {
  clock_.start();
  metrics_.start_ticking();
}

void SheetRunner::stop_clock() {
  clock_.stop();
  metrics_.stop_ticking();
}

void SheetRunner::wake() {
  clock_.wake();
  publish_state();
  start_clock();
}

void SheetRunner::tick_at_deadline(std::uint64_t call) {
  if (closed_ || is_ending_ || context_.stopping || !clock_.accept(call)) return;
  if (clock_.is_sleeping()) return repeat_if_over();
  if (!run_once(true)) return clock_.call_now();
  if (clock_.is_paused()) return;  // A replay has ended.
  if (sheet_.frozen()) {
    stop_clock();
    publish_state();
  } else if (sheet_.at_rest() && queue_.scheduled().empty() && !is_playing()) {
    fall_asleep();
  } else {
    clock_.set_timer();
  }
}

// Leaves a timer for the repeat of the scene, if it has one.
void SheetRunner::fall_asleep() {
  clock_.sleep();
  save_if_due();
  metrics_.stop_ticking();
  metrics_.fell_asleep();
  publish_state();
  publish();
  if (sheet_.config().repeat_after == 0) return;
  clock_.set_timer_after(std::max<std::int64_t>(sheet_.config().repeat_after - sheet_.scene_tick(), 0));
}

bool SheetRunner::may_repeat() const {
  if (sheet_.config().repeat_after == 0 || changes_.is_changed()) return false;
  return !clock_.is_paused() && !is_playing() && sinks_.want_snapshot();
}

void SheetRunner::repeat_if_over() {
  if (!clock_.is_sleeping() || clock_.has_timer() || !may_repeat()) return;
  repeats_now_ = true;
  wake();
}

void SheetRunner::add_sink(const std::shared_ptr<sheet::SnapshotSink>& sink) {
  metrics_.sink_added();
  sinks_.add(sink);
  publish_to(*sink);
  repeat_if_over();
}

void SheetRunner::refresh_sink(const std::shared_ptr<sheet::SnapshotSink>& sink) {
  if (sinks_.contains(sink)) publish_to(*sink);
  repeat_if_over();
}

void SheetRunner::remove_sink(const std::shared_ptr<sheet::SnapshotSink>& sink) {
  if (!sinks_.remove(sink)) return;
  metrics_.sink_removed();
  if (sinks_.is_empty()) shown_.reset();
}

}  // namespace kerf::host
