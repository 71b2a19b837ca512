#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/service/store/files.h"
#include "server/service/store/reading.h"
#include "server/service/store/sql.h"
#include "server/service/store/state_job.h"

namespace kerf::store {

// Copies a store that is in use into a new folder, step by step. Changes that are committed before the last page was
// copied are in the copy. While it runs, no state may be added, and no file of a state removed. The copy has a database
// under its name only once it is whole.
class BackupJob {
 public:
  struct Paths {
    std::string from;  // folder of the store
    std::string to;    // folder that is made; it must be missing or empty
    std::string vfs;
  };
  BackupJob(Files& files, Database& source, Paths paths, std::function<void(Status)> done);
  ~BackupJob();
  BackupJob(const BackupJob&) = delete;
  BackupJob& operator=(const BackupJob&) = delete;
  // Makes one step. Returns true if that was the last.
  Result<bool> advance();
  void call_done(const Status& status) const { done_(status); }

 private:
  struct Close {
    void operator()(sqlite3_backup* backup) const { sqlite3_backup_finish(backup); }
  };

  Status begin();
  Result<bool> copy_pages();
  Status copy_state();
  Status finish();

  Files& files_;
  Database& source_;
  Paths paths_;
  std::function<void(Status)> done_;
  std::optional<Database> target_;
  std::unique_ptr<sqlite3_backup, Close> pages_;
  bool has_pages_ = false;
  std::vector<StateInfo> states_;  // left to copy
  std::unique_ptr<FileJob> file_;
};

}  // namespace kerf::store
