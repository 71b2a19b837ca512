#include "server/api/resource_names.h"

#include <string_view>

#include "server/sheet/sheet_config.h"

namespace kerf::api {
namespace {

constexpr std::string_view kSheets = "sheets/";

}  // namespace

Result<std::string> parse_sheet_name(const std::string& name, const char* field) {
  if (name.compare(0, kSheets.size(), kSheets) == 0) {
    std::string id = name.substr(kSheets.size());
    if (sheet::is_valid_sheet_id(id)) return id;
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

std::string cut_name(const std::string& sheet_id, std::int64_t number) {
  return sheet_name(sheet_id) + "/cuts/" + std::to_string(number);
}

}  // namespace kerf::api
