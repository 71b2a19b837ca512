#include "server/service/api/resource_names.h"

#include <charconv>
#include <string_view>
#include <utility>

#include "server/core/scene/sheet_config.h"

namespace kerf::api {
namespace {

constexpr std::string_view kSheets = "sheets/";
constexpr std::string_view kScheduled = "/scheduledCuts/";
constexpr std::string_view kStates = "/states/";

}  // namespace

Result<std::string> parse_sheet_name(const std::string& name, const char* field) {
  if (name.compare(0, kSheets.size(), kSheets) == 0) {
    std::string id = name.substr(kSheets.size());
    if (scene::is_valid_sheet_id(id)) return id;
  }
  return invalid_argument("NAME_MALFORMED",
                          std::string(field) +
                              " must be sheets/{sheet}, where {sheet} is a lower-case letter and up to "
                              "62 letters, digits and hyphens",
                          field);
}

std::string sheet_name(const std::string& id) {
  return std::string(kSheets) + id;
}

std::string scheduled_name(const std::string& sheet_id, std::int64_t number) {
  return sheet_name(sheet_id) + std::string(kScheduled) + std::to_string(number);
}

Result<ScheduledName> parse_scheduled_name(const std::string& name) {
  const std::size_t slash = name.find(kScheduled);
  if (slash != std::string::npos) {
    const Result<std::string> id = parse_sheet_name(name.substr(0, slash), "name");
    ScheduledName parsed;
    const char* const digits = name.data() + slash + kScheduled.size();
    const char* const end = name.data() + name.size();
    const auto [stop, fault] = std::from_chars(digits, end, parsed.number);
    if (id.ok() && fault == std::errc() && stop == end && parsed.number > 0) {
      parsed.sheet_id = *id;
      return parsed;
    }
  }
  return invalid_argument(
      "NAME_MALFORMED", "name must be sheets/{sheet}/scheduledCuts/{number}, as in scheduled_name of the call's answer",
      "name");
}

std::string state_name(const std::string& sheet_id, const std::string& state_id) {
  return sheet_name(sheet_id) + std::string(kStates) + state_id;
}

Result<StateName> parse_state_name(const std::string& name) {
  const std::size_t slash = name.rfind(kStates);  // A sheet may be called "states", too.
  if (slash != std::string::npos) {
    const Result<std::string> id = parse_sheet_name(name.substr(0, slash), "name");
    std::string state_id = name.substr(slash + kStates.size());
    if (id.ok() && scene::is_valid_sheet_id(state_id)) return StateName{*id, std::move(state_id)};
  }
  return invalid_argument("NAME_MALFORMED", "name must be sheets/{sheet}/states/{state}, as in SavedState.name",
                          "name");
}

std::string cut_name(const std::string& sheet_id, std::int64_t number) {
  return sheet_name(sheet_id) + "/cuts/" + std::to_string(number);
}

}  // namespace kerf::api
