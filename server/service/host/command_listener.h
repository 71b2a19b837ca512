#pragma once

#include <functional>
#include <string>

#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/service/host/command_result.h"

namespace kerf::host {

// Receives the outcome of a command that has no caller to answer, on the sheet's strand. Must not block.
using CommandListener = std::function<void(const std::string& id, const sheet::Command& command,
                                           const Result<CommandResult>& result, const ScheduleId& schedule_id)>;

}  // namespace kerf::host
