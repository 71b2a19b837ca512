#pragma once

#include <cstdint>
#include <string>

#include "server/base/result.h"

namespace kerf::api {

// Returns the id in `sheets/{sheet}`; kInvalidArgument NAME_MALFORMED with the field `field`.
Result<std::string> parse_sheet_name(const std::string& name, const char* field);
std::string sheet_name(const std::string& id);

// Returns `sheets/{sheet}/scheduledCuts/{number}`. See host::ScheduleId::number.
std::string scheduled_name(const std::string& sheet_id, std::int64_t number);
struct ScheduledName {
  std::string sheet_id;
  std::int64_t number = 0;  // >= 1
};
// Parses a name that scheduled_name() made. Error: kInvalidArgument NAME_MALFORMED with field "name".
Result<ScheduledName> parse_scheduled_name(const std::string& name);

// Returns `sheets/{sheet}/states/{state}`.
std::string state_name(const std::string& sheet_id, const std::string& state_id);
struct StateName {
  std::string sheet_id;
  std::string state_id;
};
// Parses a name that state_name() made. Error: kInvalidArgument NAME_MALFORMED with field "name".
Result<StateName> parse_state_name(const std::string& name);

// Returns `sheets/{sheet}/cuts/{cut}`. See scene::CutReply::number.
std::string cut_name(const std::string& sheet_id, std::int64_t number);

}  // namespace kerf::api
