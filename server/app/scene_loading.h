#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"

namespace kerf {
class Disk;
}  // namespace kerf
namespace kerf::host {
class Host;
}  // namespace kerf::host

namespace kerf::app {

// A scene file that was read.
struct SceneOfFile {
  std::filesystem::path file;
  std::string id;  // of its sheet; empty: the server chooses
  scene::SheetConfig config;
};

// Reads scene files. A scene without sheet_id gets the file's name without extension, if that is an id. Errors name the
// file in their message; kInvalidArgument SHEET_ID_TWICE if two files have the same id.
Result<std::vector<SceneOfFile>> read_scenes(const std::vector<std::filesystem::path>& files, Disk& disk);

// Makes one paused sheet per scene and returns the ids, in order. A sheet with that id is replaced, unless it is among
// `kept`: then the scene is left out. After an error none of them is left. Errors name the file in their message.
Result<std::vector<std::string>> make_scenes(std::vector<SceneOfFile> scenes, host::Host& host,
                                             const std::set<std::string>& kept = {});

// Deletes these sheets.
void delete_sheets(const std::vector<std::string>& ids, host::Host& host);
// Starts the clocks of these sheets.
Status resume_sheets(const std::vector<std::string>& ids, host::Host& host);

}  // namespace kerf::app
