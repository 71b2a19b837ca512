#include "server/service/store/reading.h"

#include <algorithm>
#include <set>
#include <utility>

#include "server/base/crc32c.h"
#include "server/service/store/schema.h"

namespace kerf::store {
namespace {

constexpr const char* kStateColumns =
    "SELECT sheet, seq, name, number, tick, engine, state_hash, continuation_hash, bytes, content_sum, crc FROM "
    "states ";

Error entry_damaged(std::int64_t sheet, std::int64_t seq, const std::string& how) {
  return data_loss("JOURNAL_DAMAGED",
                   "entry " + std::to_string(seq) + " of sheet " + std::to_string(sheet) + " " + how);
}

StateRow state_row(const Statement& row) {
  StateRow read;
  StateInfo& state = read.state;
  state.sheet = row.integer(0);
  state.seq = row.integer(1);
  state.name = row.bytes(2);
  state.number = row.integer(3);
  state.tick = row.integer(4);
  state.engine = static_cast<std::uint64_t>(row.integer(5));
  state.state_hash = static_cast<std::uint64_t>(row.integer(6));
  state.continuation_hash = static_cast<std::uint64_t>(row.integer(7));
  state.bytes = row.integer(8);
  state.content_sum = static_cast<std::uint32_t>(row.integer(9));
  read.is_whole = row_sum(state) == row.integer(10);
  return read;
}

StoredSheet sheet_row(const Statement& row) {
  StoredSheet sheet;
  sheet.sheet = row.integer(0);
  const std::int64_t state = row.integer(1);
  sheet.is_quarantined = state == static_cast<std::int64_t>(SheetState::kQuarantined);
  sheet.created_unix_us = row.integer(2);
  sheet.id = row.bytes(4);
  sheet.reason = row.bytes(5);
  sheet.scene = row.bytes(6);
  sheet.is_damaged =
      sheet_sum(sheet.sheet, state, sheet.created_unix_us, sheet.id, sheet.reason, sheet.scene) != row.integer(3);
  return sheet;
}

KeptRequest request_row(const Statement& row) {
  KeptRequest one;
  one.request.body_hash = static_cast<std::uint64_t>(row.integer(0));
  one.sheet = row.integer(1);
  one.seq = row.integer(2);
  one.at_unix_us = row.integer(3);
  one.request.key = row.bytes(5);
  one.request.reply = row.bytes(6);
  return one;
}

// Adds the ends of each sheet's journal and its states.
Status add_rest(Database& database, std::vector<StoredSheet>& sheets) {
  KERF_TRY_ASSIGN(Statement ends,
                  Statement::prepare(database, "SELECT min(seq), max(seq) FROM journal WHERE sheet = ?"));
  KERF_TRY_ASSIGN(Statement states, Statement::prepare(database, std::string(kStateColumns) +
                                                                     "WHERE sheet = ? ORDER BY seq DESC, number DESC"));
  KERF_TRY_ASSIGN(const auto marks, read_marks(database));
  for (StoredSheet& sheet : sheets) {
    ends.begin(sheet.sheet);
    KERF_TRY(ends.step());
    sheet.first_seq = ends.integer(0);
    sheet.last_seq = ends.integer(1);
    const auto mark = marks.find(sheet.sheet);
    if (mark != marks.end()) sheet.mark = mark->second;
    states.begin(sheet.sheet);
    while (true) {
      KERF_TRY_ASSIGN(const bool is_row, states.step());
      if (!is_row) break;
      StateRow row = state_row(states);
      if (row.is_whole) {
        sheet.states.push_back(std::move(row.state));
      } else {
        ++sheet.num_damaged_states;
      }
    }
  }
  return Nothing{};
}

}  // namespace

Result<std::vector<StoredSheet>> read_sheets(Database& database) {
  KERF_TRY_ASSIGN(Statement rows, Statement::prepare(database,
                                                     "SELECT sheet, state, created, crc, id, reason, scene "
                                                     "FROM sheets ORDER BY sheet"));
  std::vector<StoredSheet> sheets;
  while (true) {
    KERF_TRY_ASSIGN(const bool is_row, rows.step());
    if (!is_row) break;
    StoredSheet sheet = sheet_row(rows);
    const bool is_deleted = rows.integer(1) == static_cast<std::int64_t>(SheetState::kDeleted);
    if (!is_deleted || sheet.is_damaged) sheets.push_back(std::move(sheet));
  }
  KERF_TRY(add_rest(database, sheets));
  return sheets;
}

Result<std::vector<host::JournalEntry>> read_entries(Database& database, std::int64_t sheet, std::int64_t after_seq) {
  KERF_TRY_ASSIGN(Statement rows, Statement::prepare(database,
                                                     "SELECT seq, tick, hash, crc, content FROM journal "
                                                     "WHERE sheet = ? AND seq > ? ORDER BY seq"));
  rows.begin(sheet, after_seq);
  std::vector<host::JournalEntry> entries;
  while (true) {
    KERF_TRY_ASSIGN(const bool is_row, rows.step());
    if (!is_row) return entries;
    host::JournalEntry entry;
    entry.sheet = sheet;
    entry.seq = rows.integer(0);
    entry.tick = rows.integer(1);
    entry.state_hash = static_cast<std::uint64_t>(rows.integer(2));
    entry.content = rows.bytes(4);
    const std::int64_t expected = after_seq + static_cast<std::int64_t>(entries.size()) + 1;
    if (entry.seq != expected) return entry_damaged(sheet, expected, "is missing");
    if (row_sum(entry) != rows.integer(3)) return entry_damaged(sheet, entry.seq, "has changed since it was written");
    entries.push_back(std::move(entry));
  }
}

Result<KeptRequests> read_requests(Database& database, std::size_t max_count, std::size_t max_bytes) {
  KERF_TRY_ASSIGN(Statement rows, Statement::prepare(database,
                                                     "SELECT body_hash, sheet, seq, at, crc, key, reply "
                                                     "FROM requests ORDER BY number DESC"));
  KeptRequests kept;
  std::set<std::string> known;
  std::size_t bytes = 0;
  while (kept.requests.size() < max_count) {
    KERF_TRY_ASSIGN(const bool is_row, rows.step());
    if (!is_row) break;
    KeptRequest one = request_row(rows);
    if (row_sum(one.request, one.sheet, one.seq, one.at_unix_us) != rows.integer(4)) {
      ++kept.num_damaged;
      continue;
    }
    if (!known.insert(one.request.key).second) continue;
    bytes += one.request.key.size() + one.request.reply.size();
    if (bytes > max_bytes) break;
    kept.requests.push_back(std::move(one));
  }
  return kept;
}

Result<StateInfo> read_state_row(Database& database, std::int64_t sheet, std::int64_t seq, const std::string& name) {
  KERF_TRY_ASSIGN(Statement rows, Statement::prepare(database, std::string(kStateColumns) +
                                                                   "WHERE sheet = ? AND seq = ? AND name = ?"));
  rows.begin(sheet, seq, std::string_view(name));
  KERF_TRY_ASSIGN(const bool is_row, rows.step());
  const std::string which = "sheet " + std::to_string(sheet) + (name.empty() ? "" : " \"" + name + "\"") +
                            " after entry " + std::to_string(seq);
  if (!is_row) return not_found("STATE_NOT_FOUND", "there is no state of " + which);
  StateRow row = state_row(rows);
  if (!row.is_whole) return data_loss("STATE_DAMAGED", "the row of the state of " + which + " has changed");
  return std::move(row.state);
}

Result<std::vector<StateRow>> read_state_rows(Database& database, std::optional<std::int64_t> sheet) {
  const std::string which = sheet ? "WHERE sheet = " + std::to_string(*sheet) + " " : "";
  KERF_TRY_ASSIGN(Statement rows, Statement::prepare(database, kStateColumns + which + "ORDER BY sheet, seq, number"));
  std::vector<StateRow> states;
  while (true) {
    KERF_TRY_ASSIGN(const bool is_row, rows.step());
    if (!is_row) return states;
    states.push_back(state_row(rows));
  }
}

Result<std::string> read_content(Files& files, const std::string& folder, const StateInfo& state) {
  const std::string path = states_path(folder) + "/" + file_name(state);
  const auto damaged = [&](const char* how) {
    return data_loss("STATE_DAMAGED", "the file of " + words_for(state) + ", \"" + path + "\", " + how);
  };
  const Result<std::int64_t> bytes = files.size(path);
  if (!bytes.ok() && bytes.error().code == ErrorCode::kNotFound) return damaged("is gone");
  if (bytes.ok() && *bytes != state.bytes) return damaged("has changed");
  KERF_TRY_ASSIGN(std::string content, files.read(path, static_cast<std::size_t>(state.bytes)));
  if (content_sum(content) != state.content_sum) return damaged("has changed");
  return content;
}

Result<std::map<std::int64_t, std::int64_t>> read_marks(Database& database) {
  std::map<std::int64_t, std::int64_t> marks;
  KERF_TRY_ASSIGN(Statement row, Statement::prepare(database, "SELECT packed, crc FROM marks WHERE id = 1"));
  KERF_TRY_ASSIGN(const bool is_row, row.step());
  if (!is_row) return marks;
  const std::string_view packed = row.bytes(0);
  if (crc32c(packed) != row.integer(1) || packed.size() % 16 != 0) return marks;
  const auto number_at = [packed](std::size_t first) {
    std::uint64_t number = 0;
    for (std::size_t i = 8; i-- > 0;) number = number << 8U | static_cast<unsigned char>(packed[first + i]);
    return static_cast<std::int64_t>(number);
  };
  for (std::size_t at = 0; at < packed.size(); at += 16) marks[number_at(at)] = number_at(at + 8);
  return marks;
}

Status check_keys(Database& database) {
  std::set<std::int64_t> sheets;
  KERF_TRY_ASSIGN(Statement numbers, Statement::prepare(database, "SELECT sheet FROM sheets WHERE state <> 2"));
  while (true) {
    KERF_TRY_ASSIGN(const bool is_row, numbers.step());
    if (!is_row) break;
    sheets.insert(numbers.integer(0));
  }
  for (const std::string table : {"journal", "states"}) {
    KERF_TRY_ASSIGN(Statement keys, Statement::prepare(database, "SELECT sheet, seq FROM " + table));
    std::pair<std::int64_t, std::int64_t> last{0, 0};
    while (true) {
      KERF_TRY_ASSIGN(const bool is_row, keys.step());
      if (!is_row) break;
      const std::pair<std::int64_t, std::int64_t> key{keys.integer(0), keys.integer(1)};
      const bool is_after = table == "journal" ? key > last && key.second > 0 : key >= last;
      if (!is_after || sheets.count(key.first) == 0) {
        return data_loss("STORE_DAMAGED", "the table " + table + " has a row for entry " + std::to_string(key.second) +
                                              " of sheet " + std::to_string(key.first) +
                                              ", which does not belong there");
      }
      last = key;
    }
  }
  return Nothing{};
}

std::string packed_marks(const std::map<std::int64_t, std::int64_t>& marks) {
  std::string packed;
  packed.reserve(16 * marks.size());
  for (const auto& [sheet, tick] : marks) {
    for (const std::int64_t number : {sheet, tick}) {
      for (unsigned shift = 0; shift < 64; shift += 8) {
        packed.push_back(static_cast<char>((static_cast<std::uint64_t>(number) >> shift) & 0xffU));
      }
    }
  }
  return packed;
}

std::int64_t sheet_sum(std::int64_t sheet, std::int64_t state, std::int64_t created, std::string_view id,
                       std::string_view reason, std::string_view scene) {
  return RowSum().add(sheet).add(state).add(created).add(id).add(reason).add(scene).value();
}

std::string file_name(const StateInfo& state) {
  return std::to_string(state.sheet) + "-" + std::to_string(state.seq) + "-" + std::to_string(state.number) + ".state";
}

std::string words_for(const StateInfo& state) {
  return state.name.empty() ? "the state after entry " + std::to_string(state.seq)
                            : "the saved state \"" + state.name + "\"";
}

}  // namespace kerf::store
