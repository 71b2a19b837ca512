#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/service/store/files.h"
#include "server/service/store/reading.h"
#include "server/service/store/sql.h"
#include "server/service/store/write_queue.h"

namespace kerf::store {

// Bounds what is kept.
struct KeepLimits {
  std::int64_t sheet_bytes = std::int64_t{16} << 20U;  // of a sheet's entries; beyond, old ones go
  std::int64_t requests = 100'000;                     // newest requests, which are kept however old they are
  std::int64_t request_us = std::int64_t{24} * 3600 * 1'000'000;  // younger ones are kept, too
};

// Counts what Tables::prune() removed.
struct Pruned {
  std::int64_t requests = 0;
  std::int64_t sheets = 0;  // Rows that deleted sheets had left.
};

// Writes the tables of a store, for one thread. Each function that changes them is one transaction: after an error,
// they are as they were, and the function can be called once more.
class Tables {
 public:
  static Result<std::unique_ptr<Tables>> open(Files& files, const std::string& folder, const std::string& vfs,
                                              const KeepLimits& limits);
  ~Tables();
  Tables(const Tables&) = delete;
  Tables& operator=(const Tables&) = delete;

  // Writes changes and ticks by sheet. Changes of sheets that were removed leave nothing but their requests. Error
  // kInternal JOURNAL_ORDER if an entry does not follow the one before it.
  Status commit(const std::vector<Change>& changes, const std::map<std::int64_t, std::int64_t>& marks,
                std::int64_t now_unix_us);
  // Makes a state count, whose file is whole. Then removes older states and, of a long journal, older entries.
  Status add_state(const StateInfo& state);
  Status quarantine(std::int64_t sheet, const std::string& reason);
  // Removes the row of a state and leaves its file.
  Status remove_state_row(const StateInfo& state);
  // Removes the entries of a sheet after `seq`, with their requests.
  Status remove_entries_after(std::int64_t sheet, std::int64_t seq);
  // Removes what need not be kept: requests and the rows of deleted sheets.
  Result<Pruned> prune(std::int64_t now_unix_us);
  // Moves the log into the database, if it is long.
  Status checkpoint();

  [[nodiscard]] Database& database() { return database_; }
  // The largest number of a sheet so far; 0: there was none.
  [[nodiscard]] std::int64_t largest_sheet() const { return largest_sheet_; }
  [[nodiscard]] std::int64_t next_state_number() { return ++largest_state_; }
  [[nodiscard]] bool has_many_new_requests() const { return num_new_requests_ >= 4096; }
  // Returns the names of files of states that no row has any more.
  std::vector<std::string> take_obsolete_files() { return std::exchange(obsolete_files_, {}); }

 private:
  struct Totals {
    std::int64_t last_seq = 0;
    std::int64_t bytes = 0;  // of the contents of its entries
  };
  // Changes of this object by a transaction, made once that is committed.
  struct Pending {
    std::map<std::int64_t, std::optional<Totals>> totals;
    std::vector<std::string> files;
    std::int64_t largest_sheet = 0;
    std::int64_t num_requests = 0;
  };
  struct Statements;

  Tables(Database database, const KeepLimits& limits);
  Status load();
  Status check_place();
  Status transaction(const std::function<Status()>& work);
  [[nodiscard]] std::optional<Totals> totals_of(std::int64_t sheet) const;
  Status write(const host::NewStoredSheet& sheet, std::int64_t now_unix_us);
  Status write(const host::JournalEntry& entry, std::int64_t now_unix_us);
  Status write(const Removal& removal, std::int64_t now_unix_us);
  Status write(const StateRemoval& removal, std::int64_t now_unix_us);
  Status remove_named(std::int64_t sheet, const std::string& name);
  Status write_requests(const std::vector<host::StoredRequest>& requests, std::int64_t sheet, std::int64_t seq,
                        std::int64_t now_unix_us);
  Status write_marks();
  Status write_sheet(const StoredSheet& sheet, SheetState state);
  Status replace_states(const StateInfo& state);
  Status remove_states(const std::string& condition);
  Status compact(std::int64_t sheet, Totals totals);

  Database database_;
  std::unique_ptr<Statements> statements_;
  KeepLimits limits_;
  Pending pending_;
  std::map<std::int64_t, Totals> totals_;  // by sheet, of all that are not deleted
  std::map<std::int64_t, std::int64_t> marks_;
  bool marks_changed_ = false;
  std::int64_t largest_sheet_ = 0;
  std::int64_t largest_state_ = 0;
  std::int64_t num_new_requests_ = 0;
  int log_pages_ = 0;
  std::vector<std::string> obsolete_files_;
};

}  // namespace kerf::store
