#pragma once

#include <cstdint>
#include <stop_token>
#include <string>

#include "kerf/v1/store_service.pb.h"
#include "server/base/result.h"

namespace kerf::api {

// Looks after the folder in which a server keeps its sheets, for StoreService. Functions wait for the disk, so they are
// called on a background thread. Thread-safe; one backup is made at a time.
class KeptStore {
 public:
  virtual ~KeptStore() = default;
  virtual Result<v1::StoreInfo> info() = 0;
  virtual Result<v1::PruneStoreResponse> prune() = 0;
  // Deletes a sheet that was set aside. Error kNotFound SET_ASIDE_NOT_FOUND.
  virtual Status delete_set_aside(std::int64_t number) = 0;
  // Makes the backup `id`, which is well-formed. It is given up soon after `stop` is triggered, and nothing is left of
  // it then, as after every error. Errors: kAlreadyExists BACKUP_EXISTS, kResourceExhausted TOO_MANY_BACKUPS, those of
  // the disk.
  virtual Result<v1::StoreBackup> back_up(const std::string& id, const std::stop_token& stop) = 0;
};

}  // namespace kerf::api
