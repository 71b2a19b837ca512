#include "server/service/host/command_answers.h"

#include "server/base/catch_exceptions.h"

namespace kerf::host {

std::vector<Result<CommandResult>> command_results(const sheet::TickReport& report,
                                                   const std::vector<PendingCommand>& pending, Nanoseconds began,
                                                   const StageTimer& timer) {
  const std::size_t num_scheduled = report.scheduled.size();
  std::vector<Result<CommandResult>> results;
  results.reserve(num_scheduled + pending.size());
  // `number`: index among the tick's commands, in the order in which they were done.
  const auto add = [&](const Result<scene::CommandReply>& reply, Nanoseconds queued, std::size_t number) {
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
    add(report.replies[i], pending[i].schedule_id.at_tick > 0 ? Nanoseconds{0} : began - pending[i].queued_at,
        report.num_scheduled_first + i);
  }
  return results;
}

CommandAnswers::~CommandAnswers() {
  refuse_all(out_of_memory());
}

void CommandAnswers::refuse_all(const Error& error) {
  while (next_ < pending_.size()) answer_next(error);
}

void CommandAnswers::answer_next(const Result<CommandResult>& result) {
  const Callback<CommandResult>& done = pending_[next_++].done;
  if (done) done(result);
}

void CommandAnswers::answer_all(const std::string& sheet_id, const scene::SheetConfig& config,
                                const sheet::TickReport& report, const std::vector<scene::Command>& commands,
                                const std::vector<Result<CommandResult>>& results, const CommandListener* listener) {
  const std::size_t num_scheduled = report.scheduled.size();
  for (std::size_t i = 0; i < num_scheduled && listener != nullptr; ++i) {
    const scene::ScheduledCommand& of_scene = config.commands[report.scheduled[i].index];
    (*listener)(sheet_id, of_scene.command, results[i], {of_scene.tick, 0});
  }
  for (std::size_t i = 0; i < pending_.size(); ++i) {
    const Result<CommandResult>& result = results[num_scheduled + i];
    const ScheduleId& schedule_id = pending_[i].schedule_id;
    const bool is_notified = !pending_[i].done && (result.ok() || schedule_id.at_tick > 0);
    if (is_notified && listener != nullptr) (*listener)(sheet_id, commands[i], result, schedule_id);
    answer_next(result);
  }
}

}  // namespace kerf::host
