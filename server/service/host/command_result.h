#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/core/sheet/sheet.h"

namespace kerf::host {

// Receives the result of a call of Host. Called exactly once: on a worker thread, or within the call if that is refused
// at once. Must not block.
template <typename T>
using Callback = std::function<void(Result<T>)>;

template <typename T>
struct NamedRequest;
// Null for a request without a name.
template <typename T>
using RequestName = std::shared_ptr<const NamedRequest<T>>;

struct CommandTimings {
  double queued_us = 0.0;  // From submit() to the tick boundary; 0 for a scheduled command.
  double cut_us = 0.0;     // Planning and applying a cut, and remeshing.
  double update_us = 0.0;  // Updating the mechanical model and the state after a cut.
  // Expected time of a tick before and after all commands of the same tick boundary; see TickEstimate.
  double tick_before_us = 0.0;
  double tick_after_us = 0.0;
  double budget_us = 0.0;  // Wall time between ticks; a longer tick is late.
};

struct CommandResult {
  scene::CommandReply reply;
  CommandTimings timings;
};

// Identifies a command that is scheduled for a tick.
struct ScheduleId {
  std::int64_t at_tick = 0;  // Tick at whose start the command is done; 0: the next tick boundary.
  std::int64_t number = 0;   // As returned by Host::schedule(): 1, 2, ... per sheet; 0 for commands of a scene.
};

// Names a request that must have its effect once, also if it is sent again after a restart, see StoredRequest.
template <typename T>
struct NamedRequest {
  std::string key;
  std::uint64_t body_hash = 0;
  std::function<std::string(const T&)> encode;  // Returns the answer to store.
};

struct ScheduledCommand {
  ScheduleId id;
  scene::Command command;
};

}  // namespace kerf::host
