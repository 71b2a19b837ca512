#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/service/store/backup_job.h"
#include "server/service/store/sqlite_store.h"
#include "server/service/store/state_job.h"
#include "server/service/store/tables.h"
#include "server/service/store/write_queue.h"

namespace kerf::store {

// Writes what a queue is given, for the one thread that calls run(). Between two pieces of a large file it commits the
// changes that came meanwhile.
class StoreThread {
 public:
  StoreThread(const StoreOptions& options, Files& files, WriteQueue& queue, std::unique_ptr<Tables> tables);
  // Takes a reserve from the disk, which is given up when that is full.
  Status make_reserve();
  // Works until the queue is stopped.
  void run();

  // For tasks, which run() calls.
  [[nodiscard]] Tables& tables() { return *tables_; }
  [[nodiscard]] bool has_failed() const { return has_failed_; }
  void add(std::unique_ptr<BackupJob> job) { backups_.push_back(std::move(job)); }

 private:
  [[nodiscard]] std::optional<std::chrono::nanoseconds> patience() const;
  // Takes all that waits behind what is under way. Returns the tasks.
  std::vector<std::function<void()>> take();
  void commit();
  void advance_files();
  void advance_backup();
  // Encodes the next state, unless memory for that is lacking.
  void begin_state();
  void advance_state();
  void remove_obsolete_files();
  void leave_full_disk();
  // Returns whether work is done. If not, it meets a full disk and is to be tried once more, or the store has failed.
  bool is_done(const Status& status);
  bool give_up_reserve();
  void fail(const Error& error);

  const StoreOptions& options_;
  Files& files_;
  WriteQueue& queue_;
  std::unique_ptr<Tables> tables_;
  WriteQueue::Taken batch_;  // Not yet durable.
  std::deque<StateChange> states_;
  std::optional<StateJob> state_;
  bool is_state_written_ = false;  // Its file is; its row is not.
  bool is_state_blocked_ = false;  // It met a full disk, and is not yet durable.
  std::deque<std::unique_ptr<BackupJob>> backups_;
  std::vector<std::string> obsolete_files_;
  bool has_reserve_ = false;
  bool waits_for_room_ = false;  // The last attempt met a full disk, or too little memory.
  bool has_failed_ = false;
};

}  // namespace kerf::store
