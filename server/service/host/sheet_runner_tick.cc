#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>

#include "server/base/caught.h"
#include "server/base/memory_headroom.h"
#include "server/service/host/sheet_runner.h"

// Runs the tick of a SheetRunner: drain, step, publish, answer, count.
namespace kerf::host {

namespace {

double microseconds(Nanoseconds time) {
  return 1.0e6 * seconds(time);
}

}  // namespace

bool SheetRunner::run_once(bool advance) {
  if (advance && is_playing()) return play_tick();
  std::vector<Pending> pending = advance && !sheet_.frozen() ? take_due() : std::vector<Pending>();
  const bool is_over = repeats_now_ || sheet_.scene_tick() >= sheet_.config().repeat_after;
  if (advance && is_over && may_repeat()) {
    pending.push_back({sheet::Reset{.repeats = true}, {}, Nanoseconds{0}, {}, true});
  }
  repeats_now_ = false;
  std::vector<Pending> queued = take_queue();
  if (!queued.empty() && !has_room_for_commands()) refuse_for_want_of_memory(queued);
  std::move(queued.begin(), queued.end(), std::back_inserter(pending));
  if (!advance && pending.empty()) return false;
  return run_commands(advance, std::move(pending));
}

// Answers commands left unanswered when memory runs out, since later work may find them half done.
class SheetRunner::Answering {
 public:
  explicit Answering(std::vector<Pending>& pending) : pending_(pending) {}
  ~Answering() {
    while (next_ < pending_.size()) answer(out_of_memory());
  }
  Answering(const Answering&) = delete;
  Answering& operator=(const Answering&) = delete;

  void answer(const Result<CommandResult>& result) {
    const Callback<CommandResult>& done = pending_[next_++].done;
    if (done) done(result);
  }

 private:
  std::vector<Pending>& pending_;
  std::size_t next_ = 0;
};

// Keeps releases in the queue, since they need no memory.
void SheetRunner::refuse_for_want_of_memory(std::vector<Pending>& queued) {
  const auto lets_go = [](const Pending& pending) { return std::holds_alternative<sheet::Release>(pending.command); };
  const auto refused = std::stable_partition(queued.begin(), queued.end(), lets_go);
  const std::int64_t count = queued.end() - refused;
  context_.board.update([&](HostMetrics& m) { m.commands_refused += count; });
  for (auto pending = refused; pending != queued.end(); ++pending) pending->done(out_of_memory());
  queued.erase(refused, queued.end());
}

bool SheetRunner::has_room_for_commands() const {
  constexpr std::int64_t kBytesPerVertex = 1000;  // At most this much is copied or added by a cut.
  return has_memory_for(kBytesPerVertex * sheet_.mesh().num_vertices());
}

bool SheetRunner::run_commands(bool advance, std::vector<Pending> pending) {
  Answering answering(pending);
  const Nanoseconds begin = context_.clock.now();
  const Nanoseconds cpu_begin = context_.clock.thread_cpu();
  const bool stands = !advance || sheet_.frozen();
  std::optional<sheet::RecordedTick> bare;  // Bare entry needed before an apply(), and so before an interrupted tick.
  if ((stands || !pending.empty()) && kept_.lags(sheet_.tick())) {
    bare = sheet::RecordedTick{sheet_.tick(), {}, sheet_.state_hash()};
  }
  std::vector<sheet::Command> commands;
  commands.reserve(pending.size());
  for (Pending& p : pending) commands.push_back(std::move(p.command));
  StageTimer timer(context_.clock);
  const bool timed = advance && !paused_;

  changing_ = true;
  const double tick_before_us = pending.empty() ? 0.0 : tick_estimate().total_us();
  tick_began_ = begin;
  const fem::GoesOn goes_on = [this] { return this->goes_on(); };
  const fem::GoesOn may_go_on = [this, asked = 0]() mutable { return this->may_go_on(++asked); };
  const sheet::TickReport report =
      advance ? sheet_.step(commands, &timer, &goes_on, &may_go_on) : sheet_.apply(commands, &timer);
  was_tick_long_ = is_tick_long();
  tick_began_ = kNoTick;

  const auto is_reset = [](const sheet::Command& command) { return std::holds_alternative<sheet::Reset>(command); };
  if (step_call_ && std::any_of(commands.begin(), commands.end(), is_reset)) step_call_->remaining = 0;
  std::vector<Result<CommandResult>> results = results_of(report, pending, begin, timer);
  if (!pending.empty()) {
    const TickEstimate after = tick_estimate();
    for (Result<CommandResult>& result : results) {
      if (!result.ok()) continue;
      result->timings.tick_before_us = tick_before_us;
      result->timings.tick_after_us = after.total_us();
      result->timings.budget_us = after.budget;
    }
  }
  note_changes(pending, commands, report);
  if (bare && (stands || report.stats.interrupted)) kept_.append(*bare);
  // Leaves out a tick whose scene commands were done without it: a recording cannot express that.
  const bool is_torn = report.gave_up && !report.scheduled.empty();
  const Nanoseconds before_record = context_.clock.now() - context_.clock.thread_cpu();
  sheet::RecordedTick entry{report.tick, std::move(commands), 0};
  if (!is_torn && !(report.stats.interrupted && entry.commands.empty())) record(entry);
  const Nanoseconds blocked = context_.clock.now() - context_.clock.thread_cpu() - before_record;
  const Nanoseconds cpu = context_.clock.thread_cpu() - cpu_begin;
  const Nanoseconds end = context_.clock.now();
  if (timed && !report.stats.interrupted) {
    pace_.tick_done(end, cpu, std::min(report.stats.simulated / sheet_.dt(), 1.0), blocked);
  } else if (report.advanced || report.stats.interrupted) {
    pace_.add_cpu(cpu);
  }
  if (report.advanced) last_step_ = report.stats;
  if (report.advanced && results.empty() && !report.step_failed) note_tick_cost(cpu);
  fem::count_flags(report.stats.flags, flagged_ticks_);
  note_status();
  publish();
  count(report, results, context_.clock.now() - begin, context_.clock.thread_cpu() - cpu_begin);
  changing_ = false;
  answer_or_tell(report, entry.commands, pending, results, answering);
  return !report.stats.interrupted;
}

void SheetRunner::note_changes(const std::vector<Pending>& pending, const std::vector<sheet::Command>& commands,
                               const sheet::TickReport& report) {
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const Result<sheet::CommandReply>& reply = report.replies[i];
    if (!reply.ok() || pending[i].is_repeat) continue;
    const bool is_reset = std::holds_alternative<sheet::Reset>(commands[i]);
    is_changed_ = !is_reset;
    if (is_reset) ++resets_;
    if (!reply->undone || !reply->undone->reset) continue;
    ++(std::holds_alternative<sheet::RedoCut>(commands[i]) ? resets_ : resets_undone_);
  }
}

TickEstimate SheetRunner::tick_estimate() const {
  return {sheet_.expected_cost(), tick_scale_ > 0.0 ? tick_scale_ : 1.0, microseconds(pace_.period())};
}

void SheetRunner::note_tick_cost(Nanoseconds cpu) {
  constexpr double kLeastWeight = 0.1;  // -, weight of the newest tick; one slow first tick soon loses weight.
  const double counted = sheet_.expected_cost().total();
  if (!(counted > 0.0) || cpu.count() <= 0) return;
  const double scale = static_cast<double>(cpu.count()) / counted;
  tick_scale_ += std::max(kLeastWeight, 1.0 / static_cast<double>(++num_timed_ticks_)) * (scale - tick_scale_);
}

bool SheetRunner::goes_on() const {
  if (context_.stopping || closing_) return false;
  if (is_playing()) return true;  // A recording cannot express an incomplete tick.
  if (step_call_ && step_call_->stop.stop_requested()) return false;
  return !((pauses_waiting_ > 0 || takes_back_waiting_) && is_tick_long());
}

bool SheetRunner::may_go_on(int asked) const {
  constexpr int kAskingsToALook = 32;  // Checks per look at the memory, which costs more.
  return !context_.stopping && !closing_ && (asked % kAskingsToALook != 0 || is_within_memory_limit());
}

bool SheetRunner::is_at_long_tick() const {
  return is_tick_long() || (was_tick_long_ && tick_began_.load() != kNoTick);
}

bool SheetRunner::is_tick_long() const {
  const Nanoseconds began = tick_began_;
  return began != kNoTick && context_.clock.now() - began > Host::kLongTick;
}

void SheetRunner::record(sheet::RecordedTick& entry) {
  const bool is_kept = kept_.wants(entry.tick, !entry.commands.empty());
  if (!is_kept && !recording_) return;
  entry.state_hash = sheet_.state_hash();
  if (is_kept) kept_.append(entry);
  if (recording_) recording_->append(entry);
}

Result<KeptRun> SheetRunner::kept_run() const {
  KERF_TRY_ASSIGN(std::string entries, kept_.until(sheet_.tick(), sheet_.state_hash()));
  return KeptRun{sheet_.shared_config(), std::move(entries)};
}

std::vector<SheetRunner::Pending> SheetRunner::take_queue() {
  std::vector<Pending> taken;
  const std::lock_guard lock(queue_mutex_);
  taken.swap(queue_);
  takes_back_waiting_ = false;
  if (!taken.empty()) {
    const auto count = static_cast<std::int32_t>(taken.size());
    context_.board.update([&](HostMetrics& m) { m.queued_commands -= count; });
  }
  return taken;
}

void SheetRunner::publish() {
  const auto wants = [](const auto& sink) { return sink->wants_snapshot(); };
  if (std::none_of(sinks_.begin(), sinks_.end(), wants)) return;
  const bool with_strains =
      std::any_of(sinks_.begin(), sinks_.end(), [&](const auto& sink) { return wants(sink) && sink->wants_strains(); });
  const std::shared_ptr<const sheet::Snapshot> snapshot = sheet_.snapshot(run_stats(), with_strains);
  context_.board.update([](HostMetrics& m) { ++m.snapshots; });
  for (const auto& sink : sinks_) {
    if (wants(sink)) sink->publish(snapshot);
  }
}

std::vector<Result<CommandResult>> SheetRunner::results_of(const sheet::TickReport& report,
                                                           const std::vector<Pending>& pending, Nanoseconds drained_at,
                                                           const StageTimer& timer) {
  const std::size_t num_scheduled = report.scheduled.size();
  std::vector<Result<CommandResult>> results;
  results.reserve(num_scheduled + pending.size());
  // `number`: index among the tick's commands, in the order in which they were done.
  const auto add = [&](const Result<sheet::CommandReply>& reply, Nanoseconds queued, std::size_t number) {
    if (!reply.ok()) {
      results.emplace_back(reply.error());
      return;
    }
    const StageTimer::CutTime time = timer.time(number);
    results.emplace_back(
        CommandResult{*reply, {microseconds(queued), microseconds(time.cut), microseconds(time.update)}});
  };
  for (std::size_t i = 0; i < num_scheduled; ++i) {
    add(report.scheduled[i].reply, Nanoseconds{0}, i < report.num_scheduled_first ? i : i + pending.size());
  }
  for (std::size_t i = 0; i < pending.size(); ++i) {
    add(report.replies[i], pending[i].appointment.at_tick > 0 ? Nanoseconds{0} : drained_at - pending[i].queued_at,
        report.num_scheduled_first + i);
  }
  return results;
}

std::vector<SheetRunner::Pending> SheetRunner::take_due() {
  std::vector<Pending> due;
  auto next = scheduled_.begin();
  for (; next != scheduled_.end() && next->appointment.at_tick <= sheet_.tick() + 1; ++next) {
    due.push_back({std::move(next->command), {}, Nanoseconds{0}, next->appointment});
  }
  scheduled_.erase(scheduled_.begin(), next);
  return due;
}

void SheetRunner::answer_or_tell(const sheet::TickReport& report, const std::vector<sheet::Command>& commands,
                                 const std::vector<Pending>& pending, const std::vector<Result<CommandResult>>& results,
                                 Answering& answering) const {
  const std::shared_ptr<const CommandListener> set = context_.listener.get();
  const CommandListener* const listener = set && *set ? set.get() : nullptr;
  const std::size_t num_scheduled = report.scheduled.size();
  for (std::size_t i = 0; i < num_scheduled && listener != nullptr; ++i) {
    const sheet::ScheduledCommand& of_scene = sheet_.config().commands[report.scheduled[i].index];
    (*listener)(id_, of_scene.command, results[i], {of_scene.tick, 0});
  }
  for (std::size_t i = 0; i < pending.size(); ++i) {
    const Result<CommandResult>& result = results[num_scheduled + i];
    const Appointment& appointment = pending[i].appointment;
    const bool is_told = !pending[i].done && (result.ok() || appointment.at_tick > 0);
    if (is_told && listener != nullptr) (*listener)(id_, commands[i], result, appointment);
    answering.answer(result);
  }
}

void SheetRunner::count(const sheet::TickReport& report, const std::vector<Result<CommandResult>>& results,
                        Nanoseconds wall, Nanoseconds cpu) {
  const bool timed = report.advanced && !paused_;
  if (timed) need_.tick_done(wall);
  const std::int64_t need = timed ? need_.value() : noted_need_;
  const auto refused = [](const auto& result) { return !result.ok(); };
  const std::int64_t num_refused = std::count_if(results.begin(), results.end(), refused);
  const std::int64_t num_done = static_cast<std::int64_t>(results.size()) - num_refused;
  const fem::TickCost cost =
      report.advanced && results.empty() && !report.step_failed ? sheet_.expected_cost() : fem::TickCost{};
  context_.board.update([&](HostMetrics& m) {
    for (std::size_t i = 0; i < cost.ns.size() && cost.total() > 0.0; ++i) {
      m.tick_part_cpu_s[i] += seconds(cpu) * cost.ns[i] / cost.total();
    }
    if (report.advanced) {
      ++m.ticks;
      m.tick_cpu_s += seconds(cpu);
      m.tick_duration.add(seconds(wall));
    }
    if (report.step_failed) ++m.failed_ticks;
    if (report.gave_up && !context_.stopping && !closing_) ++m.short_ticks;
    fem::count_flags(report.stats.flags, m.flagged_ticks);
    if (report.advanced && report.stats.newton_iterations > 0) {
      m.linear_iterations += report.stats.linear_iterations;
      m.linear_residual.add(report.stats.linear_residual);
    }
    m.commands += num_done;
    m.commands_refused += num_refused;
    for (const Result<CommandResult>& result : results) {
      if (!result.ok() || !(result->reply.cut || !result->reply.batch.empty())) continue;
      m.cut_duration.add(1.0e-6 * (result->timings.cut_us + result->timings.update_us));
    }
    m.contact_phases += sheet_.contact_phases() - contact_phases_;
    m.cuts += sheet_.num_cuts() - cuts_;
    m.overruns += pace_.overruns() - overruns_;
    m.slipped_s += seconds(pace_.slipped() - slipped_);
    m.worker_need += need - noted_need_;
  });
  contact_phases_ = sheet_.contact_phases();
  cuts_ = sheet_.num_cuts();
  overruns_ = pace_.overruns();
  slipped_ = pace_.slipped();
  noted_need_ = need;
}

void SheetRunner::note_need(std::int64_t need) {
  if (need == noted_need_) return;
  context_.board.update([&](HostMetrics& m) { m.worker_need += need - noted_need_; });
  noted_need_ = need;
}

}  // namespace kerf::host
