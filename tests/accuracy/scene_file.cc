#include "tests/accuracy/scene_file.h"

#include <fstream>
#include <sstream>

#include "server/service/wire/scene_codec.h"

namespace kerf::accuracy {

Result<scene::SheetConfig> read_scene_file(const std::filesystem::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return wire::decode_scene_file(text.str(), [](const std::string& other) {
    return Result<std::string>(invalid_argument("NO_FILES", "a reference scene names no other file", other));
  });
}

Result<offline::SceneRun> run_scene_file(const std::filesystem::path& file) {
  KERF_TRY_ASSIGN(const scene::SheetConfig config, read_scene_file(file));
  return offline::run_scene(config, {});
}

}  // namespace kerf::accuracy
