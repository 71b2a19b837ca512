// A tick: the commands that are due, then the step in time.

#include "server/core/sheet/sheet_impl.h"

namespace kerf::sheet {

TickReport Sheet::Impl::run(std::span<const scene::Command> commands, StageObserver* observer, bool advances,
                            const StopConditions& stop) {
  TickReport report;
  const std::int32_t version_before = topology_version;
  const bool advancing = advances && !moving.stepper().is_frozen();
  drain_commands(commands, observer, advancing, report);
  if (advancing) {
    advance(observer, stop, report);
  } else {
    moving.refresh_conditions();
  }
  report.topology_changed = topology_version != version_before;
  fill_report(report);
  return report;
}

// A load of a static analysis counts as a tick.
TickReport Sheet::Impl::begin_load_step() {
  TickReport report;
  const std::int32_t version_before = topology_version;
  drain_commands({}, nullptr, true, report);
  moving.refresh_conditions();
  clock.advance();
  report.topology_changed = topology_version != version_before;
  fill_report(report);
  return report;
}

void Sheet::Impl::drain_commands(std::span<const scene::Command> commands, StageObserver* observer, bool scheduled,
                                 TickReport& report) {
  const std::int32_t version_before = topology_version;
  std::int32_t number = 0;
  if (scheduled) drain_schedule(observer, number, report);
  report.num_scheduled_first = report.scheduled.size();
  report.replies.reserve(commands.size());
  for (const scene::Command& command : commands) {
    report.replies.push_back(do_command(command, {observer, number++}));
  }
  if (scheduled) drain_schedule(observer, number, report);  // of a scene that a Reset has begun again
  if (topology_version == version_before) return;
  const StageScope scope(Stage::kModelUpdate, {observer, -1});
  moving.prepare();
}

void Sheet::Impl::drain_schedule(StageObserver* observer, std::int32_t& number, TickReport& report) {
  while (const std::optional<std::size_t> index = clock.pop_due()) {
    const SchedulePlace place = clock.schedule_place();
    const scene::Command& command = moving.config().commands[*index].command;
    report.scheduled.push_back({*index, do_command(command, {observer, number++})});
    // A scheduled Reset does not repeat the schedule, which might never end.
    clock.set_schedule_place(place);
  }
}

void Sheet::Impl::advance(StageObserver* observer, const StopConditions& stop, TickReport& report) {
  const scene::Instant before = moving.conditions().now;
  {
    const StageScope scope(Stage::kLoads, {observer, -1});
    moving.set_loads(clock.end_of_next_tick());
  }
  {
    const StageScope scope(Stage::kIntegrate, {observer, -1});
    // In an interrupted tick, scheduled commands would be done without their tick, which a recording cannot express.
    const StopCondition* end_early = report.scheduled.empty() ? stop.end_early : nullptr;
    const StepOutcome outcome = moving.step({end_early, stop.give_up}, before);
    report.stats = outcome.stats;
    report.gave_up = outcome.gave_up;
    report.step_failed = outcome.failed;
  }
  if (report.stats.interrupted) return;
  clock.advance();
  report.advanced = true;
  moving.watch_rest(!clock.is_exhausted(), report.stats.self_contact.contacts > 0);
}

void Sheet::Impl::fill_report(TickReport& report) const {
  report.tick = clock.tick();
  report.frozen = moving.stepper().is_frozen();
  report.at_rest = moving.stepper().is_at_rest();
  if (report.replies.empty() && report.scheduled.empty()) return;
  const std::uint64_t hash = state_hash();
  const auto fill_reply = [&](Result<scene::CommandReply>& reply) {
    if (!reply.ok()) return;
    reply->tick = report.tick;
    reply->state_hash = hash;
  };
  for (Result<scene::CommandReply>& reply : report.replies) fill_reply(reply);
  for (ScheduledReply& scheduled : report.scheduled) fill_reply(scheduled.reply);
}

std::uint64_t Sheet::Impl::state_hash() const {
  StateHash hash;
  moving.add_to(hash);
  hash.add(clock.tick());
  return hash.value();
}

}  // namespace kerf::sheet
