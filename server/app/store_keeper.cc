#include "server/app/store_keeper.h"

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <utility>

#include "server/service/store/schema.h"
#include "server/service/store/sqlite_store.h"

namespace kerf::app {
namespace {

namespace fs = std::filesystem;

// Says which option names the folder of backups.
Error in_backups(Error error) {
  error.message = "the folder of backups (kerfd --backups): " + error.message;
  return error;
}

std::int64_t bytes_below(const fs::path& folder) {
  std::int64_t bytes = 0;
  std::error_code broken;
  fs::recursive_directory_iterator at(folder, broken);
  for (; !broken && at != fs::recursive_directory_iterator(); at.increment(broken)) {
    std::error_code no_file;
    const std::uintmax_t size = at->is_regular_file(no_file) ? at->file_size(no_file) : 0;
    if (!no_file) bytes += static_cast<std::int64_t>(size);
  }
  return bytes;
}

}  // namespace

StoreKeeper::StoreKeeper(store::SqliteStore& store, fs::path folder, fs::path backups)
    : store_(store), folder_(std::move(folder)), backups_(std::move(backups)) {}

Result<std::vector<std::string>> StoreKeeper::backup_ids() const {
  KERF_TRY_ASSIGN(std::vector<std::string> ids, store::real_files().list(backups_.string()));
  std::erase_if(ids, [this](const std::string& name) {
    const bool is_part = name.find('.') != std::string::npos;
    return is_part || !store::real_files().size(store::database_path((backups_ / name).string())).ok();
  });
  return ids;
}

Result<v1::StoreInfo> StoreKeeper::info() {
  const store::Waiting waiting = store_.waiting();
  KERF_TRY_ASSIGN(const store::StoreInfo kept, store_.info());
  const Result<std::vector<std::string>> ids = backup_ids();
  v1::StoreInfo info;
  info.set_folder(folder_.string());
  info.set_sheets(kept.sheets);
  info.set_changes(kept.entries);
  info.set_answers(kept.requests);
  info.set_states(kept.states);
  info.set_change_bytes(kept.entry_bytes);
  info.set_state_bytes(kept.state_bytes);
  info.set_database_bytes(kept.database_bytes);
  info.set_waiting_changes(static_cast<std::int64_t>(waiting.changes));
  info.set_waiting_bytes(static_cast<std::int64_t>(waiting.bytes));
  for (const store::QuarantinedSheet& sheet : kept.quarantined) {
    v1::SetAsideSheet& aside = *info.add_set_aside();
    aside.set_number(sheet.sheet);
    aside.set_sheet_id(sheet.id);
    aside.set_reason(sheet.reason);
  }
  info.set_backups_folder(backups_.string());
  if (ids.ok()) info.mutable_backup_ids()->Add(ids->begin(), ids->end());
  info.set_max_backups(static_cast<std::int32_t>(kMaxBackups));
  return info;
}

Result<v1::PruneStoreResponse> StoreKeeper::prune() {
  KERF_TRY_ASSIGN(const store::Pruned pruned, store_.prune());
  v1::PruneStoreResponse response;
  response.set_removed_answers(pruned.requests);
  response.set_removed_sheets(pruned.sheets);
  return response;
}

Status StoreKeeper::delete_set_aside(std::int64_t number) {
  KERF_TRY_ASSIGN(const store::StoreInfo kept, store_.info());
  const bool is_set_aside = std::any_of(kept.quarantined.begin(), kept.quarantined.end(),
                                        [number](const auto& sheet) { return sheet.sheet == number; });
  if (!is_set_aside) {
    return not_found("SET_ASIDE_NOT_FOUND",
                     "no sheet that was set aside has the number " + std::to_string(number) +
                         "; GetStoreInfo, or kerf store info, lists them",
                     "number");
  }
  store_.remove(number, {}, nullptr);
  return store_.wait_until_durable();
}

Result<v1::StoreBackup> StoreKeeper::back_up(const std::string& id, const std::stop_token& stop) {
  if (const Status made = store::real_files().make_folder(backups_.string()); !made.ok()) {
    return in_backups(made.error());
  }
  const Result<std::vector<std::string>> found = backup_ids();
  if (!found.ok()) return in_backups(found.error());
  if (std::find(found->begin(), found->end(), id) != found->end()) {
    return already_exists("BACKUP_EXISTS", "there is a backup \"" + id + "\" already; take another id", "backup_id");
  }
  if (found->size() >= kMaxBackups) {
    return resource_exhausted("TOO_MANY_BACKUPS", "there are " + std::to_string(kMaxBackups) +
                                                      " backups, which is the limit; remove folders from \"" +
                                                      backups_.string() + "\", or move them elsewhere");
  }
  const fs::path folder = backups_ / id;
  KERF_TRY(store_.backup(folder.string(), stop));
  v1::StoreBackup made;
  made.set_backup_id(id);
  made.set_folder(folder.string());
  made.set_num_bytes(bytes_below(folder));
  return made;
}

}  // namespace kerf::app
