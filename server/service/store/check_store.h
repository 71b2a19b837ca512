#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/service/store/files.h"
#include "server/service/store/reading.h"
#include "server/service/store/sql.h"

namespace kerf::store {

// A sheet that is kept and not recovered.
struct QuarantinedSheet {
  std::int64_t sheet = 0;
  std::string id;
  std::string reason;
};

// Counts what a store holds.
struct StoreInfo {
  std::int64_t sheets = 0;  // without deleted ones
  std::int64_t entries = 0;
  std::int64_t requests = 0;
  std::int64_t states = 0;
  std::int64_t entry_bytes = 0;               // of the contents of entries
  std::int64_t state_bytes = 0;               // of the files of states
  std::int64_t database_bytes = 0;            // of the database with its log
  std::vector<QuarantinedSheet> quarantined;  // By number; `sheets` counts them, too.
};

struct StoreReport {
  std::vector<std::string> faults;        // A sentence each; none: the store is whole.
  std::vector<std::string> known_faults;  // Like `faults`, of sheets that are quarantined.
  bool opens = true;                      // A server can open it, and says what is wrong with single sheets.
  std::vector<std::string> orphan_files;  // Files of states that no row names: an end in the middle leaves them.
  StoreInfo info;
};

// Looks at everything that a store in this folder holds, while nothing else uses it, and changes nothing. Errors:
// kNotFound STORE_NOT_FOUND, kFailedPrecondition STORE_IN_USE, STORE_FOREIGN or STORE_NEWER, kDataLoss STORE_DAMAGED if
// the tables cannot be read at all. `vfs` as for StoreOptions.
Result<StoreReport> check_store(const std::string& folder, Files& files = real_files(), const std::string& vfs = {});

// Returns what is wrong with the entries of a sheet, a sentence each.
Result<std::vector<std::string>> journal_faults(Database& database, const StoredSheet& sheet);

// Reads the counts of an open store.
Result<StoreInfo> read_info(Database& database, Files& files, const std::string& folder);

}  // namespace kerf::store
