#include "server/app/scene_loading.h"

#include <map>
#include <utility>

#include "server/app/wait_for.h"
#include "server/base/disk.h"
#include "server/service/host/host.h"
#include "server/service/wire/scene_codec.h"

namespace kerf::app {
namespace {

Error in_file(const std::filesystem::path& file, Error error) {
  const std::string field = error.field.empty() ? "" : error.field + ": ";
  error.message = "scene " + file.string() + ": " + field + error.message;
  return error;
}

Result<SceneOfFile> read_scene(const std::filesystem::path& file, Disk& disk) {
  const Result<std::string> json = disk.read_file(file.string(), wire::kMaxSceneFileBytes);
  if (!json.ok()) return in_file(file, json.error());
  const wire::FileReader read_file = [&](const std::string& path) {
    return disk.read_file((file.parent_path() / path).string(), scene::kMaxMeshFileBytes);
  };
  Result<scene::SheetConfig> config = wire::decode_scene_file(*json, read_file);
  if (!config.ok()) return in_file(file, config.error());
  const std::string stem = file.stem().string();
  std::string id = config->sheet_id.empty() && scene::is_valid_sheet_id(stem) ? stem : config->sheet_id;
  return SceneOfFile{file, std::move(id), std::move(config).value()};
}

Status delete_sheet(const std::string& id, host::Host& host) {
  return wait_for<Nothing>([&](host::Callback<Nothing> done) { host.delete_sheet(id, std::move(done)); });
}

// `replaced`: sheets that the scene may replace. Returns the id.
Result<std::string> make_scene(SceneOfFile scene, host::Host& host, std::set<std::string>& replaced) {
  if (replaced.erase(scene.id) > 0) {
    if (const Status deleted = delete_sheet(scene.id, host); !deleted.ok()) return in_file(scene.file, deleted.error());
  }
  const Result<host::SheetStatus> status = wait_for<host::SheetStatus>([&](host::Callback<host::SheetStatus> done) {
    host.create_sheet(scene.id, std::move(scene.config), true, std::move(done));
  });
  if (!status.ok()) return in_file(scene.file, status.error());
  return status->id;
}

}  // namespace

Result<std::vector<SceneOfFile>> read_scenes(const std::vector<std::filesystem::path>& files, Disk& disk) {
  std::vector<SceneOfFile> scenes;
  std::map<std::string, std::filesystem::path> file_of;  // by id
  for (const std::filesystem::path& file : files) {
    KERF_TRY_ASSIGN(SceneOfFile scene, read_scene(file, disk));
    const auto [other, is_first] = file_of.emplace(scene.id, file);
    if (!scene.id.empty() && !is_first) {
      return in_file(
          file, invalid_argument("SHEET_ID_TWICE", "its sheet has the id \"" + scene.id + "\", as that of " +
                                                       other->second.string() + "; give one of them another sheet_id"));
    }
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

Result<std::vector<std::string>> make_scenes(std::vector<SceneOfFile> scenes, host::Host& host,
                                             const std::set<std::string>& kept) {
  const std::vector<std::string> present = host.list();
  std::set<std::string> replaced(present.begin(), present.end());
  std::vector<std::string> ids;
  for (SceneOfFile& scene : scenes) {
    if (kept.contains(scene.id)) continue;
    Result<std::string> id = make_scene(std::move(scene), host, replaced);
    if (!id.ok()) {
      delete_sheets(ids, host);
      return id.error();
    }
    ids.push_back(std::move(*id));
  }
  return ids;
}

void delete_sheets(const std::vector<std::string>& ids, host::Host& host) {
  for (const std::string& id : ids) (void)delete_sheet(id, host);  // Those that are gone already need nothing.
}

Status resume_sheets(const std::vector<std::string>& ids, host::Host& host) {
  for (const std::string& id : ids) {
    const Result<host::SheetStatus> status =
        wait_for<host::SheetStatus>([&](host::Callback<host::SheetStatus> done) { host.resume(id, std::move(done)); });
    // Ignores a sheet deleted meanwhile by a client, since a transport already listens.
    if (!status.ok() && status.error().code != ErrorCode::kNotFound) return status.error();
  }
  return Nothing{};
}

}  // namespace kerf::app
