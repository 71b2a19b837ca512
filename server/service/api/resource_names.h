#pragma once

#include <cstdint>
#include <string>

#include "server/base/result.h"

namespace kerf::api {

// The id in `sheets/{sheet}`; kInvalidArgument NAME_MALFORMED with this field.
Result<std::string> parse_sheet_name(const std::string& name, const char* field);
std::string sheet_name(const std::string& id);

// `sheets/{sheet}/scheduledCuts/{number}`. See host::Appointment::number.
std::string scheduled_name(const std::string& sheet_id, std::int64_t number);
struct ScheduledName {
  std::string sheet_id;
  std::int64_t number = 0;  // >= 1
};
// kInvalidArgument NAME_MALFORMED with field "name".
Result<ScheduledName> parse_scheduled_name(const std::string& name);

// `sheets/{sheet}/cuts/{cut}`. See sheet::CutReply::number.
std::string cut_name(const std::string& sheet_id, std::int64_t number);

}  // namespace kerf::api
