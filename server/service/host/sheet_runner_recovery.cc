#include <algorithm>
#include <utility>
#include <variant>

#include "server/base/overloaded.h"
#include "server/service/host/errors.h"
#include "server/service/host/sheet_runner.h"

// Repeats what a journal has of a sheet.
namespace kerf::host {

Result<std::optional<std::int64_t>> SheetRunner::recover(const StoredRun& run) {
  created_unix_us_ = run.created_unix_us;
  std::optional<std::int64_t> differs_at;
  RunEvent last;
  if (run.state) {
    KERF_TRY(take_over(run.state->run));
    last = {run.state->run.paused, run.state->run.speed};
  }
  for (const StoredRun::Change& change : run.changes) {
    const auto* tick = std::get_if<TickEvent>(&change.event);
    KERF_TRY(advance_to(tick != nullptr && !tick->is_apply ? change.tick - 1 : change.tick));
    KERF_TRY(repeat(change.event, last));
    if (!differs_at && (sheet_.tick() != change.tick || sheet_.state_hash() != change.state_hash)) {
      differs_at = change.tick;
    }
  }
  KERF_TRY(advance_to(run.mark_tick));
  keep_in(*context_.options.journal, run.sheet, run.last_seq);
  continue_as(last);
  return differs_at;
}

// The sheet was loaded from the run already.
Status SheetRunner::take_over(const SavedRun& run) {
  queue_.replace_scheduled(run.scheduled, run.last_schedule_number);
  changes_ = run.changes;
  flagged_ticks_ = run.flagged_ticks;
  recorder_.replace(run.recording, "the sheet was made again from the data folder; its earlier run is in another file");
  const auto attachments = context_.attachments.get();
  if (attachments && attachments->load) attachments->load(id_, run.attachment);
  return Nothing{};
}

Status SheetRunner::advance_to(std::int64_t tick) {
  while (sheet_.tick() < tick && !sheet_.frozen()) {
    if (!run_commands(true, {})) return host_stopping();
  }
  return Nothing{};
}

Status SheetRunner::repeat(const SheetEvent& event, RunEvent& last) {
  return std::visit(Overloaded{
                        [&](const TickEvent& tick) { return repeat_tick(tick); },
                        [&](const ScheduledCommand& each) -> Status {
                          KERF_TRY(queue_.schedule(each.command, each.id.at_tick, sheet_.tick()));
                          return Nothing{};
                        },
                        [&](const CancelEvent& cancel) -> Status {
                          KERF_TRY(queue_.cancel(cancel.number));
                          return Nothing{};
                        },
                        [](const RestoreEvent&) -> Status {
                          return data_loss("RESTORE_WITHOUT_STATE", "a state was restored here, and is not kept");
                        },
                        [&](const RunEvent& run) -> Status {
                          last = run;
                          return Nothing{};
                        },
                    },
                    event);
}

Status SheetRunner::repeat_tick(const TickEvent& tick) {
  std::vector<PendingCommand> pending;
  for (const scene::Command& command : tick.commands) {
    pending.push_back({command, {}, context_.clock.now()});
    const auto* reset = std::get_if<scene::Reset>(&command);
    pending.back().is_repeat = reset != nullptr && reset->repeats;
  }
  for (const SettledCommand& settled : tick.settled) {
    pending[settled.index].schedule_id = settled.id;
    KERF_TRY(queue_.cancel(settled.id.number));
  }
  return run_commands(!tick.is_apply, std::move(pending)) ? Status(Nothing{}) : Status(host_stopping());
}

// Gives the sheet the run state that it had; begin() has paused it.
void SheetRunner::continue_as(const RunEvent& run) {
  clock_.set_speed(run.speed);
  metrics_.set_period(clock_.pace().period());
  if (!run.is_paused) {
    clock_.resume();
    if (!sheet_.frozen() && sheet_.at_rest() && queue_.scheduled().empty()) fall_asleep();
  }
  publish_state();
  publish_status();
}

void SheetRunner::start_recovered() {
  if (run_state() == RunState::kRunning && !clock_.has_timer()) start_clock();
}

}  // namespace kerf::host
