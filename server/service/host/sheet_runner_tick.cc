#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>

#include "server/base/memory_headroom.h"
#include "server/service/host/command_answers.h"
#include "server/service/host/host.h"
#include "server/service/host/sheet_runner.h"
#include "server/service/host/stage_timer.h"

// Runs the ticks of a SheetRunner, also those of replays and of step() calls. A tick takes the commands, steps,
// records, publishes, counts and answers.
namespace kerf::host {

bool SheetRunner::run_once(bool advance) {
  if (advance && is_playing()) return play_tick();
  std::vector<PendingCommand> pending;
  if (advance && !sheet_.frozen()) pending = queue_.pop_due(sheet_.tick() + 1);
  const bool is_over = repeats_now_ || sheet_.scene_tick() >= sheet_.config().repeat_after;
  if (advance && is_over && may_repeat()) {
    pending.push_back({scene::Reset{.repeats = true}, {}, Nanoseconds{0}, {}, true});
  }
  repeats_now_ = false;
  std::vector<PendingCommand> queued = queue_.take_queued();
  if (!queued.empty() && !has_room_for(queued)) refuse_for_want_of_memory(queued);
  std::move(queued.begin(), queued.end(), std::back_inserter(pending));
  if (!advance && pending.empty()) return false;
  return run_commands(advance, std::move(pending));
}

bool SheetRunner::run_commands(bool advance, std::vector<PendingCommand> taken) {
  const auto outcome = std::make_shared<TickOutcome>(std::move(taken));
  std::vector<PendingCommand>& pending = outcome->answers.pending();
  const Nanoseconds begin = context_.clock.now();
  const Nanoseconds cpu_begin = context_.clock.thread_cpu();
  const auto hash = [this] { return sheet_.state_hash(); };
  const bool stands = !advance || sheet_.frozen();
  // A step that is interrupted becomes an apply() too.
  if (stands || !pending.empty()) recorder_.prepare(sheet_.tick(), hash);
  std::vector<scene::Command> commands;
  commands.reserve(pending.size());
  for (PendingCommand& each : pending) commands.push_back(std::move(each.command));
  StageTimer timer(context_.clock);
  const bool timed = advance && !clock_.is_paused();

  changing_ = true;
  const double tick_before_us = pending.empty() ? 0.0 : tick_estimate().total_us();
  progress_.begin();
  const StopCondition stop = [this] { return is_interrupted(); };
  const StopCondition give_up = [this, polls = 0]() mutable { return must_give_up(++polls); };
  sheet::TickReport report = advance ? sheet_.step(commands, &timer, &stop, &give_up) : sheet_.apply(commands, &timer);
  progress_.end();

  const bool interrupted = report.stats.interrupted;
  const auto is_reset = [](const scene::Command& command) { return std::holds_alternative<scene::Reset>(command); };
  if (step_call_ && std::any_of(commands.begin(), commands.end(), is_reset)) step_call_->remaining = 0;
  std::vector<Result<CommandResult>>& results = outcome->results;
  results = command_results(report, pending, begin, timer);
  if (!pending.empty()) {
    const TickEstimate after = tick_estimate();
    for (Result<CommandResult>& result : results) {
      if (!result.ok()) continue;
      result->timings.tick_before_us = tick_before_us;
      result->timings.tick_after_us = after.total_us();
      result->timings.budget_us = after.budget;
    }
  }
  count_changes(pending, commands, report);

  recorder_.settle(stands || interrupted);
  // Leaves out a tick that was given up after the scene's own commands for it were done: a recording cannot express
  // that.
  const bool is_torn = report.gave_up && !report.scheduled.empty();
  const Nanoseconds before_record = context_.clock.now() - context_.clock.thread_cpu();
  sheet::RecordedTick entry{report.tick, std::move(commands), 0};
  const bool is_recorded = !is_torn && !(interrupted && entry.commands.empty());
  if (is_recorded) recorder_.append(entry, hash);
  outcome->commands = std::move(entry.commands);
  if (is_recorded) store_tick(*outcome, stands || interrupted);
  const Nanoseconds blocked = context_.clock.now() - context_.clock.thread_cpu() - before_record;
  const Nanoseconds cpu = context_.clock.thread_cpu() - cpu_begin;
  const Nanoseconds end = context_.clock.now();
  if (timed && !interrupted) {
    clock_.tick_done(end, cpu, std::min(report.stats.simulated / sheet_.dt(), 1.0), blocked);
  } else if (report.advanced || interrupted) {
    clock_.add_cpu(cpu);
  }
  if (context_.options.journal != nullptr) unsaved_.add(cpu);
  is_unsaved_ = true;

  if (report.advanced) last_step_ = report.stats;
  std::optional<fem::TickCost> cost;
  if (report.advanced && results.empty() && !report.step_failed) {
    cost = sheet_.expected_cost();
    tick_scale_.tick_done(cpu, cost->total());
  }
  fem::count_flags(report.stats.flags, flagged_ticks_);
  publish_status();
  publish();
  const RunMetrics::Tick tick{context_.clock.now() - begin,
                              context_.clock.thread_cpu() - cpu_begin,
                              report.advanced && !clock_.is_paused(),
                              report.gave_up && !context_.stopping && !closing_,
                              cost,
                              totals()};
  metrics_.tick_done(tick, report, results);
  changing_ = false;
  if (results.empty()) {
    save_if_due();
    return !interrupted;
  }
  outcome->report = std::move(report);
  journal_.when_durable(
      [outcome, id = id_, config = sheet_.shared_config(), listener = context_.listener.get()](const Status& stored) {
        if (!stored.ok()) return outcome->answers.refuse_all(stored.error());
        outcome->answers.answer_all(id, *config, outcome->report, outcome->commands, outcome->results,
                                    listener && *listener ? listener.get() : nullptr);
      });
  return !interrupted;
}

void SheetRunner::store_tick(TickOutcome& outcome, bool is_apply) {
  if (!journal_.is_on() || outcome.commands.empty()) return;
  TickEvent event{std::move(outcome.commands), {}, {}, is_apply};
  std::vector<StoredRequest> requests;
  const std::vector<PendingCommand>& pending = outcome.answers.pending();
  const std::size_t num_scheduled = outcome.results.size() - pending.size();
  for (std::size_t i = 0; i < pending.size(); ++i) {
    if (pending[i].schedule_id.number > 0) event.settled.push_back({i, pending[i].schedule_id});
    if (pending[i].is_of_stream) event.of_streams.push_back(i);
    const Result<CommandResult>& result = outcome.results[num_scheduled + i];
    if (!result.ok()) continue;
    for (StoredRequest& request : journal_.answered(pending[i].request, *result))
      requests.push_back(std::move(request));
  }
  SheetEvent stored_event(std::move(event));
  store(stored_event, std::move(requests));
  outcome.commands = std::move(std::get<TickEvent>(stored_event).commands);
}

void SheetRunner::count_changes(const std::vector<PendingCommand>& pending, const std::vector<scene::Command>& commands,
                                const sheet::TickReport& report) {
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const Result<scene::CommandReply>& reply = report.replies[i];
    if (reply.ok() && !pending[i].is_repeat) changes_.command_done(commands[i], *reply);
    // A Release is refused if a Reset has removed the grab; its name is free then, too.
    if (const auto* const release = std::get_if<scene::Release>(&commands[i])) stream_grabs_.erase(release->grab_id);
    const auto* const grab = std::get_if<scene::Grab>(&commands[i]);
    if (grab == nullptr || !reply.ok()) continue;
    if (pending[i].is_of_stream) {
      stream_grabs_.insert(grab->grab_id);
    } else {
      stream_grabs_.erase(grab->grab_id);
    }
  }
}

RunMetrics::Totals SheetRunner::totals() const {
  return {sheet_.contact_phases(), sheet_.num_cuts(), clock_.pace().overruns(), clock_.pace().slipped()};
}

TickEstimate SheetRunner::tick_estimate() const {
  return {sheet_.expected_cost(), tick_scale_.value(), microseconds(clock_.pace().period())};
}

bool SheetRunner::is_interrupted() const {
  if (context_.stopping || closing_) return true;
  if (is_playing()) return false;  // A recording cannot express an incomplete tick.
  if (step_call_ && step_call_->stop.stop_requested()) return true;
  return (pauses_waiting_ > 0 || queue_.has_revert()) && progress_.is_long();
}

bool SheetRunner::must_give_up(int polls) const {
  constexpr int kPollsToOneLook = 32;  // Polls per look at the free memory, which costs more than the other checks.
  return context_.stopping || closing_ || (polls % kPollsToOneLook == 0 && !is_within_memory_limit());
}

bool SheetRunner::play_tick() {
  if (!play_applied()) return false;
  if (is_playing() && !playback_->is_tick_done()) {
    const bool has_entry = playback_->next_at(sheet_.tick() + 1) != nullptr;
    if (!(has_entry ? play_entry(true) : run_commands(true, {}))) return false;
    playback_->tick_done();
    if (!play_applied()) return false;
  }
  if (is_playing() && sheet_.frozen()) playback_->stuck(sheet_.tick(), sheet_.state_hash());
  playback_->next_tick();
  if (!is_playing()) end_playback();
  return true;
}

// Plays the entries applied while time stood still. There may be any number of them; one turn plays a few.
bool SheetRunner::play_applied() {
  for (std::int32_t i = 0; playback_->next_at(sheet_.tick()) != nullptr; ++i) {
    if (i == Host::kEntriesPerTurn || context_.stopping || closing_) return false;
    play_entry(false);
  }
  return true;
}

bool SheetRunner::play_entry(bool advance) {
  const sheet::RecordedTick& entry = *playback_->next_at(sheet_.tick() + (advance ? 1 : 0));
  std::vector<PendingCommand> pending;
  pending.reserve(entry.commands.size());
  for (const scene::Command& command : entry.commands) {
    pending.push_back({command, {}, context_.clock.now()});
  }
  if (!run_commands(advance, std::move(pending))) {
    if (sheet_.frozen()) playback_->stuck(sheet_.tick(), sheet_.state_hash());
    return false;
  }
  playback_->passed(sheet_.tick(), sheet_.state_hash());
  return true;
}

// Pauses the sheet, which takes commands from clients from here on.
void SheetRunner::end_playback() {
  if (step_call_) step_call_->remaining = 0;
  ++state_changes_;
  if (clock_.is_paused()) {
    publish_status();
    publish();
  } else {
    pause();
  }
}

void SheetRunner::take_turn() {
  if (closed_ || !step_call_ || step_call_->is_reserved) return;
  for (std::int32_t i = 0; i < Host::kTicksPerTurn && step_call_->remaining > 0; ++i) {
    if (context_.stopping) return;  // close() answers the call.
    // Lets a waiting pause run before the next long tick. A turn of short ticks ends soon enough without this.
    if (pauses_waiting_ > 0 && progress_.was_long()) break;
    if (step_call_->stop.stop_requested()) return finish_step(Nothing{});
    if (!run_once(true)) break;
    --step_call_->remaining;  // -1 if the tick has ended the call, by a Reset or the end of a recording.
    if (!sheet_.frozen()) continue;
    finish_step(failed_precondition("SHEET_FROZEN", "no finite step, or no memory for one, was found at tick " +
                                                        std::to_string(sheet_.tick()) +
                                                        "; the sheet is frozen there: reset it"));
    return;
  }
  if (step_call_->remaining > 0) {
    turn_posted_ = strand_.post([self = shared_from_this()] {
      self->turn_posted_ = false;
      self->keep_or_lose([&] { self->take_turn(); });
    });
    return;
  }
  finish_step(Nothing{});
}

void SheetRunner::finish_step(const Status& result) {
  const StepDone done = std::move(step_call_->done);
  step_call_.reset();
  if (playback_) playback_->next_tick();
  store_run_state();
  publish_state();
  done(*this, result);
  commands_arrived();
}

}  // namespace kerf::host
