#pragma once

#include <filesystem>

#include "client/cli/scene_run.h"

namespace kerf::accuracy {

// Does what the scene file says, as `kerf run` does. Errors: those of the file and of the run; a scene that names
// another file is refused (NO_FILES).
Result<cli::SceneRun> run_scene_file(const std::filesystem::path& file);

}  // namespace kerf::accuracy
