#include "server/app/scene_loading.h"

#include <optional>
#include <utility>

#include <google/protobuf/empty.pb.h>

#include "kerf/v1/sheets.pb.h"
#include "server/app/wait_for.h"
#include "server/base/disk.h"
#include "server/service/api/api.h"
#include "server/service/api/resource_names.h"
#include "server/service/host/host.h"
#include "server/service/wire/scene_codec.h"

namespace kerf::app {
namespace {

Error in_file(const std::filesystem::path& file, Error error) {
  const std::string field = error.field.empty() ? "" : error.field + ": ";
  error.message = "scene " + file.string() + ": " + field + error.message;
  return error;
}

// Returns no id if the sheet of the file is among those kept. `replaced`: sheets that a file may replace.
Result<std::optional<std::string>> load(const std::filesystem::path& file, Disk& disk, host::Host& host, api::Api& api,
                                        const std::set<std::string>& kept, std::set<std::string>& replaced) {
  const Result<std::string> json = disk.read_file(file.string(), wire::kMaxSceneFileBytes);
  if (!json.ok()) return in_file(file, json.error());
  const wire::FileReader read_file = [&](const std::string& path) {
    return disk.read_file((file.parent_path() / path).string(), scene::kMaxMeshFileBytes);
  };
  Result<scene::SheetConfig> config = wire::decode_scene_file(*json, read_file);
  if (!config.ok()) return in_file(file, config.error());
  const std::string stem = file.stem().string();
  const std::string id = config->sheet_id.empty() && scene::is_valid_sheet_id(stem) ? stem : config->sheet_id;
  if (kept.contains(id)) return std::optional<std::string>();
  if (replaced.erase(id) > 0) {
    v1::DeleteSheetRequest request;
    request.set_name(api::sheet_name(id));
    const auto deleted = wait_for<google::protobuf::Empty>(
        [&](api::Reply<google::protobuf::Empty> done) { api.delete_sheet(request, std::move(done)); });
    if (!deleted.ok()) return in_file(file, deleted.error());
  }
  const Result<host::SheetStatus> status = wait_for<host::SheetStatus>([&](host::Callback<host::SheetStatus> done) {
    host.create_sheet(id, std::move(config).value(), true, std::move(done));
  });
  if (!status.ok()) return in_file(file, status.error());
  return std::optional(status->id);
}

}  // namespace

Result<std::vector<std::string>> load_scenes(const std::vector<std::filesystem::path>& files, Disk& disk,
                                             host::Host& host, api::Api& api, const std::set<std::string>& kept) {
  const std::vector<std::string> present = host.list();
  std::set<std::string> replaced(present.begin(), present.end());
  std::vector<std::string> ids;
  for (const std::filesystem::path& file : files) {
    KERF_TRY_ASSIGN(std::optional<std::string> id, load(file, disk, host, api, kept, replaced));
    if (id) ids.push_back(std::move(*id));
  }
  return ids;
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
