#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/service/host/journal.h"
#include "server/service/store/files.h"
#include "server/service/store/row_sums.h"
#include "server/service/store/sql.h"

namespace kerf::store {

enum class SheetState : std::int64_t { kLive = 0, kQuarantined = 1, kDeleted = 2 };

// A sheet of the store, as recovery needs it.
struct StoredSheet {
  std::int64_t sheet = 0;
  std::string id;
  std::string scene;
  std::int64_t created_unix_us = 0;
  bool is_quarantined = false;
  std::string reason;                // Why it is quarantined.
  bool is_damaged = false;           // Its row has changed: of the fields only `sheet` can be relied on.
  std::int64_t first_seq = 0;        // Oldest entry that is kept; 0: none.
  std::int64_t last_seq = 0;         // Newest entry; 0: none.
  std::optional<std::int64_t> mark;  // Latest tick that was marked.
  std::vector<StateInfo> states;     // Newest first, damaged ones left out.
  std::int64_t num_damaged_states = 0;
};

// An answer that is kept, and the entry that it came with: seq 0 is the creation or the removal of the sheet.
struct KeptRequest {
  host::StoredRequest request;
  std::int64_t sheet = 0;
  std::int64_t seq = 0;
  std::int64_t at_unix_us = 0;
};

struct StateRow {
  StateInfo state;
  bool is_whole = false;  // If not, no field of `state` can be relied on.
};

struct KeptRequests {
  std::vector<KeptRequest> requests;  // Newest first; of each key the newest alone.
  std::int64_t num_damaged = 0;       // Left out.
};

// Read from the database of a store. Errors: kDataLoss STORE_DAMAGED, kUnavailable STORE_IO.
Result<std::vector<StoredSheet>> read_sheets(Database& database);
// Returns the entries of a sheet after `after_seq` in order. Error kDataLoss JOURNAL_DAMAGED, with sheet and seq, if
// one is missing or has changed.
Result<std::vector<host::JournalEntry>> read_entries(Database& database, std::int64_t sheet, std::int64_t after_seq);
// Returns the newest requests, up to a number and the sum of the bytes of their keys and answers.
Result<KeptRequests> read_requests(Database& database, std::size_t max_count, std::size_t max_bytes);
// Returns the state with this name, empty for unnamed ones. Errors: kNotFound STATE_NOT_FOUND, kDataLoss STATE_DAMAGED.
Result<StateInfo> read_state_row(Database& database, std::int64_t sheet, std::int64_t seq, const std::string& name);
// Returns the states of a sheet, or of all sheets, in order.
Result<std::vector<StateRow>> read_state_rows(Database& database, std::optional<std::int64_t> sheet = std::nullopt);
// Returns the content of a state. Errors: kDataLoss STATE_DAMAGED if its file in the store's folder is gone or changed,
// those of Files if it cannot be read.
Result<std::string> read_content(Files& files, const std::string& folder, const StateInfo& state);
// Returns ticks by sheet. A damaged row has none, as marks may be lost.
Result<std::map<std::int64_t, std::int64_t>> read_marks(Database& database);

// Checks that entries and states are in the order of their keys, and of sheets that are there. A changed key would hide
// the last entry of a sheet. Error kDataLoss STORE_DAMAGED.
Status check_keys(Database& database);

std::string packed_marks(const std::map<std::int64_t, std::int64_t>& marks);
std::int64_t sheet_sum(std::int64_t sheet, std::int64_t state, std::int64_t created, std::string_view id,
                       std::string_view reason, std::string_view scene);
// Returns the name of the file that holds the state, below the folder of states.
std::string file_name(const StateInfo& state);
// Names a state in a message: the state "before", or the state after entry 3.
std::string words_for(const StateInfo& state);

}  // namespace kerf::store
