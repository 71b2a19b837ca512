#pragma once

#include <filesystem>

#include "server/service/offline/run.h"

namespace kerf::accuracy {

// Errors: those of the file; a scene that names another file is refused (NO_FILES).
Result<scene::SheetConfig> read_scene_file(const std::filesystem::path& file);

// Does what the scene file says, as `kerf run` does. Errors: those of read_scene_file and of the run.
Result<offline::SceneRun> run_scene_file(const std::filesystem::path& file);

}  // namespace kerf::accuracy
