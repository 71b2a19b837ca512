#include "server/app/scene_loading.h"

#include <future>
#include <memory>
#include <utility>

#include "server/base/disk.h"
#include "server/service/host/host.h"
#include "server/service/wire/scene_codec.h"

namespace kerf::app {
namespace {

// Blocks until the call is answered; no transport listens yet, so there is nothing else to do.
template <typename T, typename Start>
Result<T> wait_for(const Start& start) {
  const auto promise = std::make_shared<std::promise<Result<T>>>();
  std::future<Result<T>> future = promise->get_future();
  start([promise](Result<T> result) { promise->set_value(std::move(result)); });
  return future.get();
}

Error in_file(const std::filesystem::path& file, Error error) {
  const std::string field = error.field.empty() ? "" : error.field + ": ";
  error.message = "scene " + file.string() + ": " + field + error.message;
  return error;
}

Result<std::string> load(const std::filesystem::path& file, Disk& disk, host::Host& host) {
  const Result<std::string> json = disk.read_file(file.string(), wire::kMaxSceneFileBytes);
  if (!json.ok()) return in_file(file, json.error());
  const wire::FileReader read_file = [&](const std::string& path) {
    return disk.read_file((file.parent_path() / path).string(), scene::kMaxMeshFileBytes);
  };
  Result<scene::SheetConfig> config = wire::decode_scene_file(*json, read_file);
  if (!config.ok()) return in_file(file, config.error());
  const std::string stem = file.stem().string();
  const std::string id = config->sheet_id.empty() && scene::is_valid_sheet_id(stem) ? stem : config->sheet_id;
  const Result<host::SheetStatus> status = wait_for<host::SheetStatus>([&](host::Callback<host::SheetStatus> done) {
    host.create_sheet(id, std::move(config).value(), true, std::move(done));
  });
  if (!status.ok()) return in_file(file, status.error());
  return status->id;
}

}  // namespace

Result<std::vector<std::string>> load_scenes(const std::vector<std::filesystem::path>& files, Disk& disk,
                                             host::Host& host) {
  std::vector<std::string> ids;
  for (const std::filesystem::path& file : files) {
    KERF_TRY_ASSIGN(std::string id, load(file, disk, host));
    ids.push_back(std::move(id));
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
