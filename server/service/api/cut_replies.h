#pragma once

#include <string>
#include <vector>

#include "kerf/v1/cuts.pb.h"
#include "server/core/scene/command.h"
#include "server/service/host/command_result.h"

// Makes the answers of CutService from the results of commands.
namespace kerf::api {

// Returns one result for a Cut, and one per cut for a CutBatch, with equal shares of the times.
std::vector<v1::CutResult> encode_results(const std::string& sheet_id, const host::CommandResult& result);

// Return the answer to a CutBatch and to a Cut. `results`: those of encode_results().
v1::CreateCutsResponse encode_batch(const host::CommandResult& result, std::vector<v1::CutResult> results);
v1::CutResult encode_one(const host::CommandResult& result, std::vector<v1::CutResult> results);

v1::UndoResult encode_undo(const std::string& sheet_id, const host::CommandResult& result);

// Returns the cuts of a Cut or CutBatch; none for other commands.
std::vector<v1::Cut> cuts_of(const scene::Command& command);

// Returns a scheduled command of cuts as it waits.
v1::ScheduledCuts encode_scheduled(const std::string& sheet_id, const scene::Command& command,
                                   const host::ScheduleId& schedule_id);

}  // namespace kerf::api
