#pragma once

#include <cstddef>
#include <string>
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

// Returns the results of all commands of a tick: first those of report.scheduled, then those of `pending`, each in
// order. `began`: when the tick began. Estimates of tick times are left at 0.
std::vector<Result<CommandResult>> command_results(const sheet::TickReport& report,
                                                   const std::vector<PendingCommand>& pending, Nanoseconds began,
                                                   const StageTimer& timer);

// Answers each command of a tick once, in order. The destructor answers those left with kResourceExhausted
// OUT_OF_MEMORY, since later work may find them half done.
class CommandAnswers {
 public:
  // `pending` must outlive this; its commands may have been moved out.
  explicit CommandAnswers(const std::vector<PendingCommand>& pending) : pending_(pending) {}
  ~CommandAnswers();
  CommandAnswers(const CommandAnswers&) = delete;
  CommandAnswers& operator=(const CommandAnswers&) = delete;

  // Answers each command, or passes it to `listener` (may be null), before the next one. `commands`: those of the
  // pending ones, in order. `results`: see command_results().
  void answer_all(const std::string& sheet_id, const sheet::SheetConfig& config, const sheet::TickReport& report,
                  const std::vector<sheet::Command>& commands, const std::vector<Result<CommandResult>>& results,
                  const CommandListener* listener);

 private:
  void answer_next(const Result<CommandResult>& result);

  const std::vector<PendingCommand>& pending_;
  std::size_t next_ = 0;
};

}  // namespace kerf::host
