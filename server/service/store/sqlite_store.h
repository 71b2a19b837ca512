#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "server/service/host/journal.h"
#include "server/service/store/check_store.h"
#include "server/service/store/damaged_states.h"
#include "server/service/store/files.h"
#include "server/service/store/reading.h"
#include "server/service/store/tables.h"
#include "server/service/store/write_queue.h"

namespace kerf::store {

struct StoreOptions {
  std::string folder;  // Made if it is missing, with those around it.
  // Called once, on the store's thread, with the first error after which nothing more is written: no callback comes
  // from then on. The program should end, and recover by opening the store once more.
  std::function<void(const std::string& message)> failed;
  std::function<std::chrono::nanoseconds()> now;  // A time that never decreases.
  std::function<std::int64_t()> unix_us;          // us since 1970
  QueueLimits limits;
  KeepLimits keep;
  std::chrono::nanoseconds retry_delay = std::chrono::seconds(1);  // between attempts to write to a full disk
  std::int64_t reserve_bytes = std::int64_t{64} << 20U;            // given up when the disk is full; 0: none
  Files* files = nullptr;                                          // nullptr: real_files()
  std::string vfs;  // Name of a virtual file system of SQLite; empty: the machine's.
};

// Keeps sheets in a folder, by SQLite and files. One thread writes: it takes all that waits, of all sheets, as one
// transaction. README.md says what is promised. Functions beside those of Journal wait for that thread, so callbacks
// must not call them; after StoreOptions::failed() they return kUnavailable STORAGE_FAILED.
class SqliteStore : public host::Journal {
 public:
  // Opens or makes a store. Errors: kFailedPrecondition STORE_IN_USE, STORE_FOREIGN or STORE_NEWER, kDataLoss
  // STORE_DAMAGED, kUnavailable STORE_IO or FILE_IO, kResourceExhausted STORAGE_FULL or DISK_FULL.
  static Result<std::unique_ptr<SqliteStore>> open(StoreOptions options);
  // Ends without writing what waits: call wait_until_durable() before.
  ~SqliteStore() override;
  SqliteStore(const SqliteStore&) = delete;
  SqliteStore& operator=(const SqliteStore&) = delete;

  std::int64_t new_sheet_number() override;
  void create(host::NewStoredSheet sheet, Durable durable) override;
  void append(host::JournalEntry entry, Durable durable) override;
  void remove(std::int64_t sheet, std::vector<host::StoredRequest> requests, Durable durable) override;
  void save(host::StoredState state, Durable durable) override;
  void remove_state(std::int64_t sheet, std::string name, Durable durable) override;
  void mark(std::vector<host::SheetMark> marks) override;
  [[nodiscard]] Status check_room(std::int64_t sheet) const override;
  bool flush(std::chrono::milliseconds limit) override;

  // Waits until all that was given is durable and its callbacks were called; on a full disk, until there is room.
  Status wait_until_durable();

  // Read what is durable. Errors as those of reading.h.
  Result<std::vector<StoredSheet>> sheets();
  Result<std::vector<host::JournalEntry>> entries(std::int64_t sheet, std::int64_t after_seq);
  Result<KeptRequests> requests(std::size_t max_count, std::size_t max_bytes);
  // Returns the state after the entry `seq` with its content. Errors: kNotFound STATE_NOT_FOUND, kDataLoss
  // STATE_DAMAGED.
  Result<host::StoredState> read_state(std::int64_t sheet, std::int64_t seq, const std::string& name = {});
  Result<StoreInfo> info();
  // Counts what is given and not yet durable, without waiting.
  [[nodiscard]] Waiting waiting() const;

  // Marks a sheet as one that is not to be recovered. It keeps all it has. Error kNotFound SHEET_NOT_FOUND.
  Status quarantine(std::int64_t sheet, const std::string& reason);
  // Returns what is wrong with the entries of a sheet, also with those before its newest state: a sentence each.
  Result<std::vector<std::string>> journal_faults(const StoredSheet& sheet);
  // See damaged_states.h. Call it once the sheet can do without these states.
  Result<std::vector<DamagedState>> set_damaged_states_aside(std::int64_t sheet);
  // Removes the entries of a sheet after `seq` with their requests, which were never answered.
  Status remove_entries_after(std::int64_t sheet, std::int64_t seq);
  // Copies the store into a new folder while it is in use. The folder has its name only once the copy is whole and
  // synced; until then it is called FOLDER.part. Errors: kFailedPrecondition FOLDER_NOT_EMPTY; kAborted BACKUP_STOPPED
  // soon after `stop` is triggered, also while the disk is full.
  Status backup(const std::string& folder, const std::stop_token& stop = {});
  // Removes answers that need not be kept any more, and rows that deleted sheets have left. The store does this by
  // itself, too, now and then.
  Result<Pruned> prune();

 private:
  struct Impl;
  explicit SqliteStore(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::store
