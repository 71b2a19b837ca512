#include "server/app/store_keeper.h"

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <utility>

#include "server/service/store/sqlite_store.h"

namespace kerf::app {
namespace {

namespace fs = std::filesystem;

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

// Returns a path that does not depend on the folder in which kerfd was started, where that is known.
fs::path made_absolute(fs::path path) {
  std::error_code unknown;
  fs::path found = fs::absolute(path, unknown);
  return unknown ? std::move(path) : std::move(found);
}

}  // namespace

StoreKeeper::StoreKeeper(store::SqliteStore& store, fs::path folder, fs::path backups)
    : store_(store), folder_(made_absolute(std::move(folder))), backups_(made_absolute(std::move(backups))) {}

Result<std::vector<std::string>> StoreKeeper::backup_ids() const {
  KERF_TRY_ASSIGN(std::vector<std::string> ids, store::real_files().list(backups_.string()));
  std::erase_if(ids, [](const std::string& name) { return name.find('.') != std::string::npos; });
  return ids;
}

Result<v1::StoreInfo> StoreKeeper::info() {
  const store::Waiting waiting = store_.waiting();
  KERF_TRY_ASSIGN(const store::StoreInfo kept, store_.info());
  KERF_TRY_ASSIGN(const std::vector<std::string> ids, backup_ids());
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
  for (const std::string& id : ids) info.add_backup_ids(id);
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

Result<v1::StoreBackup> StoreKeeper::back_up(const std::string& id, const std::stop_token& stop) {
  KERF_TRY(store::real_files().make_folder(backups_.string()));
  KERF_TRY_ASSIGN(const std::vector<std::string> ids, backup_ids());
  if (std::find(ids.begin(), ids.end(), id) != ids.end()) {
    return already_exists("BACKUP_EXISTS", "there is a backup \"" + id + "\" already; take another id", "backup_id");
  }
  if (ids.size() >= kMaxBackups) {
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
