#pragma once

#include <cstdint>
#include <string>

#include "server/base/result.h"

namespace kerf::api {

// The id in `sheets/{sheet}`; kInvalidArgument NAME_MALFORMED with this field.
Result<std::string> parse_sheet_name(const std::string& name, const char* field);
std::string sheet_name(const std::string& id);

// `sheets/{sheet}/cuts/{cut}`. An applied cut is named by the topology version that it made, which no other can have.
std::string cut_name(const std::string& sheet_id, std::int32_t topology_version);

}  // namespace kerf::api
