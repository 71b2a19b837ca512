#pragma once

#include <functional>
#include <string>

#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/service/host/command_result.h"

namespace kerf::host {

// Receives the outcome of a command of the sheet `id` that no caller waits for, see Host::set_command_listener().
// Called on the sheet's strand; must not block.
using CommandListener = std::function<void(const std::string& id, const scene::Command& command,
                                           const Result<CommandResult>& result, const ScheduleId& schedule_id)>;

}  // namespace kerf::host
