#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "server/base/result.h"

namespace kerf {
class Disk;
}  // namespace kerf
namespace kerf::api {
class Api;
}  // namespace kerf::api
namespace kerf::host {
class Host;
}  // namespace kerf::host

namespace kerf::app {

// Makes one paused sheet per scene file and returns the ids, in order. A scene without sheet_id gets the file's name
// without extension. A sheet with that id is replaced, unless it is among `kept`: then the file is left out. Errors
// name the file in their message.
Result<std::vector<std::string>> load_scenes(const std::vector<std::filesystem::path>& files, Disk& disk,
                                             host::Host& host, api::Api& api, const std::set<std::string>& kept);

// Starts the clocks of these sheets.
Status resume_sheets(const std::vector<std::string>& ids, host::Host& host);

}  // namespace kerf::app
