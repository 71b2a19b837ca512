#pragma once

#include <cstdint>
#include <functional>

#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/core/sheet/sheet.h"

namespace kerf::host {

// Called exactly once: on a worker thread, or within the call if it is refused at once. Must not block.
template <typename T>
using Callback = std::function<void(Result<T>)>;

struct CommandTimings {
  double queued_us = 0.0;  // From submit() to the tick boundary; 0 for a scheduled command.
  double cut_us = 0.0;     // Plan, apply, remesh.
  double update_us = 0.0;  // Update of model and state.
  // Expected time of a tick before and after the commands of this boundary; see TickEstimate.
  double tick_before_us = 0.0;
  double tick_after_us = 0.0;
  double budget_us = 0.0;  // a tick's period on the wall clock
};

struct CommandResult {
  sheet::CommandReply reply;
  CommandTimings timings;
};

// Identifies a command that is scheduled for a tick.
struct ScheduleId {
  std::int64_t at_tick = 0;  // 0: at the next tick boundary.
  std::int64_t number = 0;   // Number of the call of schedule(): 1, 2, ... per sheet; 0 for commands of a scene.
};

struct ScheduledCommand {
  ScheduleId id;
  sheet::Command command;
};

}  // namespace kerf::host
