#pragma once

#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "server/core/scene/command.h"
#include "server/service/host/command_result.h"

namespace kerf::host {

// A scheduled command that was done or refused in a tick.
struct SettledCommand {
  std::size_t index = 0;  // into TickEvent::commands
  ScheduleId id;
};

// Commands from outside that a sheet did, in order; those of the scene are not repeated.
struct TickEvent {
  std::vector<scene::Command> commands;
  std::vector<SettledCommand> settled;
  // Those of grabs that end with their stream, and so with the process: indices into `commands`.
  std::vector<std::size_t> of_streams;
  bool is_apply = false;  // Time stood still; else a tick followed the commands.
};

struct CancelEvent {
  std::int64_t number = 0;  // as returned by Host::schedule()
};

struct RunEvent {
  bool is_paused = false;
  double speed = 1.0;  // -, see Host::set_speed()
};

// A saved state was restored. A StoredState with the number of this change has it.
struct RestoreEvent {};

// A change of a sheet that its journal keeps. A ScheduledCommand was scheduled.
using SheetEvent = std::variant<TickEvent, ScheduledCommand, CancelEvent, RunEvent, RestoreEvent>;

// True if viewers are shown the event only once it is durable. What hands do, such as drags, is shown at once, since a
// crash may lose it.
bool is_edit(const SheetEvent& event);

}  // namespace kerf::host
