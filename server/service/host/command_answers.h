#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/sheet.h"
#include "server/service/host/clock.h"
#include "server/service/host/command_listener.h"
#include "server/service/host/command_queue.h"
#include "server/service/host/command_result.h"
#include "server/service/host/stage_timer.h"

namespace kerf::host {

// Returns the results of all commands of a tick: first those of report.scheduled, which are the scene's own commands,
// then those of `pending`, each in order. `began`: time at which the tick began. `timer`: has timed the tick's cuts.
// CommandTimings::tick_before_us, tick_after_us and budget_us are left at 0.
std::vector<Result<CommandResult>> command_results(const sheet::TickReport& report,
                                                   const std::vector<PendingCommand>& pending, Nanoseconds began,
                                                   const StageTimer& timer);

// Answers each command of a tick once, in order. The destructor answers commands that have no answer yet with
// kResourceExhausted OUT_OF_MEMORY, because the tick has then run out of memory.
class CommandAnswers {
 public:
  explicit CommandAnswers(std::vector<PendingCommand> pending) : pending_(std::move(pending)) {}
  ~CommandAnswers();
  CommandAnswers(const CommandAnswers&) = delete;
  CommandAnswers& operator=(const CommandAnswers&) = delete;

  // Passes the scene's own commands with their results to `listener` (may be null). Then calls the callback of each
  // pending command with its result, in order. A pending command without a callback is passed to `listener` instead,
  // unless it failed and was not scheduled. `commands`: the command of each pending one, in the same order. `results`:
  // see command_results().
  void answer_all(const std::string& sheet_id, const scene::SheetConfig& config, const sheet::TickReport& report,
                  const std::vector<scene::Command>& commands, const std::vector<Result<CommandResult>>& results,
                  const CommandListener* listener);
  // Passes `error` to the callback of each pending command.
  void refuse_all(const Error& error);

  // The commands themselves may have been moved out.
  [[nodiscard]] std::vector<PendingCommand>& pending() { return pending_; }

 private:
  void answer_next(const Result<CommandResult>& result);

  std::vector<PendingCommand> pending_;
  std::size_t next_ = 0;  // Index of the pending command to be answered next.
};

}  // namespace kerf::host
