#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/service/api/kept_store.h"

namespace kerf::store {
class SqliteStore;
}  // namespace kerf::store

namespace kerf::app {

inline constexpr std::size_t kMaxBackups = 16;

// Lets clients look at a store, prune it and back it up. They choose the names of backups, never paths.
class StoreKeeper : public api::KeptStore {
 public:
  // `folder` is that of the store. `backups` contains a folder for each backup; it is made with the first if it is
  // missing.
  StoreKeeper(store::SqliteStore& store, std::filesystem::path folder, std::filesystem::path backups);

  Result<v1::StoreInfo> info() override;
  Result<v1::PruneStoreResponse> prune() override;
  Status delete_set_aside(std::int64_t number) override;
  Result<v1::StoreBackup> back_up(const std::string& id, const std::stop_token& stop) override;

 private:
  // Returns the ids of the backups in order. One that was interrupted does not count.
  [[nodiscard]] Result<std::vector<std::string>> backup_ids() const;

  store::SqliteStore& store_;
  const std::filesystem::path folder_;
  const std::filesystem::path backups_;
};

}  // namespace kerf::app
