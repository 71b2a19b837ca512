#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "server/service/store/files.h"
#include "server/service/store/reading.h"
#include "server/service/store/sql.h"
#include "server/service/store/state_job.h"

namespace kerf::store {

// Copies a store that is in use into a new folder, step by step. Changes that are committed before the last page was
// copied are in the copy. While it runs, no state may be added, and no file of a state removed. The folder has its name
// only once the copy is whole; until then it is called FOLDER.part, which is removed if the copy is given up.
class BackupJob {
 public:
  struct Paths {
    std::string from;  // folder of the store
    std::string to;    // folder that is made; it must be missing or empty
    std::string vfs;
    bool takes_damaged = false;  // Copies what can be read: states that are damaged are left out.
  };
  // `stop` gives the copy up at its next step.
  BackupJob(Files& files, Database& source, Paths paths, std::stop_token stop, std::function<void(Status)> done);
  ~BackupJob();
  BackupJob(const BackupJob&) = delete;
  BackupJob& operator=(const BackupJob&) = delete;
  // Makes one step. Returns true if that was the last. Errors: kFailedPrecondition FOLDER_NOT_EMPTY, kAborted
  // BACKUP_STOPPED, kDataLoss STATE_DAMAGED, those of Files and of sql.h.
  Result<bool> advance();
  [[nodiscard]] bool is_stopped() const { return stop_.stop_requested(); }
  // Gives the copy up if the last step was not made, and passes the outcome on.
  void end(const Status& status);

 private:
  struct Close {
    void operator()(sqlite3_backup* backup) const { sqlite3_backup_finish(backup); }
  };

  Status begin();
  Result<bool> copy_pages();
  Status copy_state();
  Status check_may_be_left_out(const StateInfo& state, Error error);
  Status check_part();
  Status finish();

  Files& files_;
  Database& source_;
  Paths paths_;
  std::string part_;  // where the copy is made
  std::stop_token stop_;
  std::function<void(Status)> done_;
  std::optional<Database> target_;
  std::unique_ptr<sqlite3_backup, Close> pages_;
  bool has_begun_ = false;  // The folder of the copy may be there.
  bool has_pages_ = false;
  std::vector<StateInfo> states_;  // left to copy
  std::unique_ptr<FileJob> file_;
};

}  // namespace kerf::store
