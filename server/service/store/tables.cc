#include "server/service/store/tables.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "server/base/crc32c.h"
#include "server/service/store/schema.h"

namespace kerf::store {
namespace {

constexpr int kLongLogPages = 1000;  // As SQLite's own default: 4 MB.

std::string of_sheet(std::int64_t sheet) {
  return "sheet = " + std::to_string(sheet);
}

}  // namespace

struct Tables::Statements {
  Statement entry, request, sheet, mark, state;
};

Result<std::unique_ptr<Tables>> Tables::open(Files& files, const std::string& folder, const std::string& vfs,
                                             const KeepLimits& limits) {
  KERF_TRY_ASSIGN(Database database, open_database(files, folder, vfs));
  std::unique_ptr<Tables> tables(new Tables(std::move(database), limits));
  KERF_TRY(tables->load());
  return tables;
}

Tables::Tables(Database database, const KeepLimits& limits) : database_(std::move(database)), limits_(limits) {}

Tables::~Tables() = default;

Status Tables::load() {
  KERF_TRY_ASSIGN(Statement entry, Statement::prepare(database_, "INSERT INTO journal VALUES(?, ?, ?, ?, ?, ?)"));
  KERF_TRY_ASSIGN(Statement request,
                  Statement::prepare(database_, "INSERT INTO requests VALUES(NULL, ?, ?, ?, ?, ?, ?, ?)"));
  KERF_TRY_ASSIGN(Statement sheet,
                  Statement::prepare(database_, "INSERT OR REPLACE INTO sheets VALUES(?, ?, ?, ?, ?, ?, ?)"));
  KERF_TRY_ASSIGN(Statement mark, Statement::prepare(database_, "INSERT OR REPLACE INTO marks VALUES(1, ?, ?)"));
  KERF_TRY_ASSIGN(Statement state, Statement::prepare(database_,
                                                      "INSERT OR REPLACE INTO states "
                                                      "VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"));
  statements_.reset(
      new Statements{std::move(entry), std::move(request), std::move(sheet), std::move(mark), std::move(state)});
  KERF_TRY(check_keys(database_));
  KERF_TRY_ASSIGN(largest_sheet_, database_.number("SELECT max(sheet) FROM sheets"));
  KERF_TRY_ASSIGN(largest_state_, database_.number("SELECT max(number) FROM states"));
  KERF_TRY_ASSIGN(marks_, read_marks(database_));
  KERF_TRY_ASSIGN(Statement rows, Statement::prepare(database_,
                                                     "SELECT sheet, (SELECT max(seq) FROM journal WHERE "
                                                     "sheet = sheets.sheet), (SELECT sum(length(content)) FROM "
                                                     "journal WHERE sheet = sheets.sheet), (SELECT max(seq) FROM "
                                                     "states WHERE sheet = sheets.sheet) FROM sheets "
                                                     "WHERE state <> 2"));
  while (true) {
    KERF_TRY_ASSIGN(const bool is_row, rows.step());
    if (!is_row) break;
    // The last entries may be lost, and a state that follows them be there: the next is counted from that.
    totals_[rows.integer(0)] = {std::max(rows.integer(1), rows.integer(3)), rows.integer(2)};
  }
  sqlite3_wal_hook(
      database_.handle(),
      [](void* self, sqlite3*, const char*, int pages) {
        static_cast<Tables*>(self)->log_pages_ = pages;
        return SQLITE_OK;
      },
      this);
  return Nothing{};
}

// SQLite would write on into files that were removed or replaced, and everything would be lost at the end.
Status Tables::check_place() {
  int has_moved = 0;
  const int code = sqlite3_file_control(database_.handle(), "main", SQLITE_FCNTL_HAS_MOVED, &has_moved);
  if (code == SQLITE_OK && has_moved != 0) {
    return unavailable("STORE_MOVED", "the file of the database was removed or replaced by another program");
  }
  return Nothing{};
}

Status Tables::transaction(const std::function<Status()>& work) {
  pending_ = Pending{};
  KERF_TRY(check_place());
  Status done = database_.execute("BEGIN IMMEDIATE");
  if (done.ok()) done = work();
  if (done.ok()) done = database_.execute("COMMIT");
  if (!done.ok()) {
    if (sqlite3_get_autocommit(database_.handle()) == 0) (void)database_.execute("ROLLBACK");
    return done;
  }
  for (const auto& [sheet, totals] : pending_.totals) {
    if (totals) {
      totals_[sheet] = *totals;
    } else {
      totals_.erase(sheet);
    }
  }
  obsolete_files_.insert(obsolete_files_.end(), pending_.files.begin(), pending_.files.end());
  largest_sheet_ = std::max(largest_sheet_, pending_.largest_sheet);
  num_new_requests_ += pending_.num_requests;
  return done;
}

std::optional<Tables::Totals> Tables::totals_of(std::int64_t sheet) const {
  if (const auto changed = pending_.totals.find(sheet); changed != pending_.totals.end()) return changed->second;
  const auto found = totals_.find(sheet);
  return found == totals_.end() ? std::nullopt : std::optional<Totals>(found->second);
}

Status Tables::commit(const std::vector<Change>& changes, const std::map<std::int64_t, std::int64_t>& marks,
                      std::int64_t now_unix_us) {
  Status done = transaction([&]() -> Status {
    for (const Change& change : changes) {
      KERF_TRY(std::visit([&](const auto& what) { return write(what, now_unix_us); }, change.what));
    }
    for (const auto& [sheet, tick] : marks) {
      if (!totals_of(sheet)) continue;
      std::int64_t& mark = marks_[sheet];
      marks_changed_ = marks_changed_ || mark != tick;
      mark = tick;
    }
    return marks_changed_ ? write_marks() : Nothing{};
  });
  if (done.ok()) marks_changed_ = false;
  return done;
}

Status Tables::write(const host::NewStoredSheet& sheet, std::int64_t now_unix_us) {
  StoredSheet row;
  row.sheet = sheet.sheet;
  row.id = sheet.id;
  row.scene = sheet.scene;
  row.created_unix_us = sheet.created_unix_us;
  KERF_TRY(write_sheet(row, SheetState::kLive));
  pending_.totals[sheet.sheet] = Totals{};
  pending_.largest_sheet = std::max(pending_.largest_sheet, sheet.sheet);
  return write_requests(sheet.requests, sheet.sheet, 0, now_unix_us);
}

Status Tables::write(const host::JournalEntry& entry, std::int64_t now_unix_us) {
  std::optional<Totals> totals = totals_of(entry.sheet);
  if (!totals && entry.sheet <= std::max(largest_sheet_, pending_.largest_sheet)) {
    return write_requests(entry.requests, entry.sheet, 0, now_unix_us);
  }
  if (!totals || entry.seq != totals->last_seq + 1) {
    return internal_error("JOURNAL_ORDER", "entry " + std::to_string(entry.seq) + " of sheet " +
                                               std::to_string(entry.sheet) + " does not follow the one before it");
  }
  totals->last_seq = entry.seq;
  totals->bytes += static_cast<std::int64_t>(entry.content.size());
  pending_.totals[entry.sheet] = totals;
  KERF_TRY(statements_->entry.run(entry.sheet, entry.seq, entry.tick, static_cast<std::int64_t>(entry.state_hash),
                                  row_sum(entry), Blob{entry.content}));
  // A mark beyond the entry is that of a time which the entry has taken back.
  const auto mark = marks_.find(entry.sheet);
  if (mark != marks_.end() && mark->second > entry.tick) {
    mark->second = entry.tick;
    marks_changed_ = true;
  }
  return write_requests(entry.requests, entry.sheet, entry.seq, now_unix_us);
}

// Keeps an empty row of the sheet until prune(), so that the largest number is known.
Status Tables::write(const Removal& removal, std::int64_t now_unix_us) {
  const std::string where = of_sheet(removal.sheet);
  if (totals_of(removal.sheet)) {
    KERF_TRY(database_.execute("DELETE FROM journal WHERE " + where));
    KERF_TRY(remove_states(where));
    StoredSheet row;
    row.sheet = removal.sheet;
    KERF_TRY(write_sheet(row, SheetState::kDeleted));
    pending_.totals[removal.sheet] = std::nullopt;
    marks_changed_ = marks_.erase(removal.sheet) > 0 || marks_changed_;
  }
  return write_requests(removal.requests, removal.sheet, 0, now_unix_us);
}

Status Tables::write(const StateRemoval& removal, std::int64_t /*now_unix_us*/) {
  return totals_of(removal.sheet) ? remove_named(removal.sheet, removal.name) : Status(Nothing{});
}

Status Tables::write_requests(const std::vector<host::StoredRequest>& requests, std::int64_t sheet, std::int64_t seq,
                              std::int64_t now_unix_us) {
  for (const host::StoredRequest& request : requests) {
    KERF_TRY(statements_->request.run(static_cast<std::int64_t>(request.body_hash), sheet, seq, now_unix_us,
                                      row_sum(request, sheet, seq, now_unix_us), std::string_view(request.key),
                                      Blob{request.reply}));
    ++pending_.num_requests;
  }
  return Nothing{};
}

Status Tables::write_marks() {
  const std::string packed = packed_marks(marks_);
  return statements_->mark.run(std::int64_t{crc32c(packed)}, Blob{packed});
}

Status Tables::write_sheet(const StoredSheet& sheet, SheetState state) {
  const auto number = static_cast<std::int64_t>(state);
  return statements_->sheet.run(
      sheet.sheet, number, sheet.created_unix_us,
      sheet_sum(sheet.sheet, number, sheet.created_unix_us, sheet.id, sheet.reason, sheet.scene),
      std::string_view(sheet.id), std::string_view(sheet.reason), Blob{sheet.scene});
}

Status Tables::add_state(const StateInfo& state) {
  return transaction([&]() -> Status {
    const std::optional<Totals> totals = totals_of(state.sheet);
    if (!totals) {
      pending_.files.push_back(file_name(state));
      return Nothing{};
    }
    KERF_TRY(replace_states(state));
    return totals->bytes > limits_.sheet_bytes ? compact(state.sheet, *totals) : Nothing{};
  });
}

// Keeps the last two unnamed states and the latest of each name.
Status Tables::replace_states(const StateInfo& state) {
  const std::string own = of_sheet(state.sheet);
  if (state.name.empty()) {
    KERF_TRY(remove_states(own + " AND name = '' AND seq = " + std::to_string(state.seq)));
  } else {
    KERF_TRY(remove_named(state.sheet, state.name));
  }
  KERF_TRY(statements_->state.run(state.sheet, state.seq, std::string_view(state.name), state.number, state.tick,
                                  static_cast<std::int64_t>(state.engine), static_cast<std::int64_t>(state.state_hash),
                                  static_cast<std::int64_t>(state.continuation_hash), state.bytes,
                                  std::int64_t{state.content_sum}, row_sum(state)));
  return remove_states(own + " AND name = '' AND seq NOT IN (SELECT seq FROM states WHERE " + own +
                       " AND name = '' ORDER BY seq DESC LIMIT 2)");
}

Status Tables::remove_named(std::int64_t sheet, const std::string& name) {
  KERF_TRY_ASSIGN(Statement same, Statement::prepare(database_, "SELECT number FROM states WHERE " + of_sheet(sheet) +
                                                                    " AND name = ?"));
  same.begin(std::string_view(name));
  std::vector<std::int64_t> found;
  while (true) {
    KERF_TRY_ASSIGN(const bool is_row, same.step());
    if (!is_row) break;
    found.push_back(same.integer(0));
  }
  for (const std::int64_t number : found) KERF_TRY(remove_states("number = " + std::to_string(number)));
  return Nothing{};
}

Status Tables::remove_states(const std::string& condition) {
  KERF_TRY_ASSIGN(Statement files,
                  Statement::prepare(database_, "SELECT sheet, seq, number FROM states WHERE " + condition));
  while (true) {
    KERF_TRY_ASSIGN(const bool is_row, files.step());
    if (!is_row) break;
    StateInfo gone;
    gone.sheet = files.integer(0);
    gone.seq = files.integer(1);
    gone.number = files.integer(2);
    pending_.files.push_back(file_name(gone));
  }
  return database_.execute("DELETE FROM states WHERE " + condition);
}

// Removes the entries up to the second-last unnamed state: two states remain from which the sheet can be recovered.
// Named ones do not count, as another of that name takes their place.
Status Tables::compact(std::int64_t sheet, Totals totals) {
  const std::string own = of_sheet(sheet);
  const std::string second =
      "(SELECT seq FROM states WHERE " + own + " AND name = '' ORDER BY seq DESC LIMIT 1 OFFSET 1)";
  KERF_TRY(database_.execute("DELETE FROM journal WHERE " + own + " AND seq <= " + second));
  const std::string rest = "SELECT sum(length(content)) FROM journal WHERE " + own;
  KERF_TRY_ASSIGN(totals.bytes, database_.number(rest.c_str()));
  pending_.totals[sheet] = totals;
  return Nothing{};
}

Status Tables::remove_state_row(const StateInfo& state) {
  KERF_TRY_ASSIGN(Statement row,
                  Statement::prepare(database_, "DELETE FROM states WHERE sheet = ? AND seq = ? AND name = ?"));
  return transaction([&] { return row.run(state.sheet, state.seq, std::string_view(state.name)); });
}

Status Tables::remove_entries_after(std::int64_t sheet, std::int64_t seq) {
  return transaction([&]() -> Status {
    std::optional<Totals> totals = totals_of(sheet);
    if (!totals) return Nothing{};
    const std::string own = of_sheet(sheet);
    const std::string late = own + " AND seq > " + std::to_string(seq);
    KERF_TRY(database_.execute("DELETE FROM journal WHERE " + late));
    KERF_TRY(database_.execute("DELETE FROM requests WHERE " + late));
    const std::string rest = "SELECT coalesce(sum(length(content)), 0) FROM journal WHERE " + own;
    KERF_TRY_ASSIGN(totals->bytes, database_.number(rest.c_str()));
    totals->last_seq = std::min(totals->last_seq, seq);
    pending_.totals[sheet] = totals;
    return Nothing{};
  });
}

Status Tables::quarantine(std::int64_t sheet, const std::string& reason) {
  KERF_TRY_ASSIGN(const std::vector<StoredSheet> sheets, read_sheets(database_));
  const auto found = std::find_if(sheets.begin(), sheets.end(), [&](const auto& one) { return one.sheet == sheet; });
  if (found == sheets.end()) return not_found("SHEET_NOT_FOUND", "the store has no sheet " + std::to_string(sheet));
  return transaction([&] {
    StoredSheet row = *found;
    row.reason = reason;
    return write_sheet(row, SheetState::kQuarantined);
  });
}

Result<Pruned> Tables::prune(std::int64_t now_unix_us) {
  Pruned pruned;
  const std::string old = "SELECT max(number) FROM requests WHERE number <= (SELECT max(number) FROM requests) - " +
                          std::to_string(limits_.requests) + " AND at < " +
                          std::to_string(now_unix_us - limits_.request_us);
  const Status done = transaction([&]() -> Status {
    KERF_TRY(database_.execute("DELETE FROM requests WHERE number <= (" + old + ")"));
    pruned.requests = sqlite3_changes64(database_.handle());
    KERF_TRY(database_.execute("DELETE FROM sheets WHERE state = 2 AND sheet < (SELECT max(sheet) FROM sheets)"));
    pruned.sheets = sqlite3_changes64(database_.handle());
    return Nothing{};
  });
  KERF_TRY(done);
  num_new_requests_ = 0;
  return pruned;
}

Status Tables::checkpoint() {
  if (log_pages_ < kLongLogPages) return Nothing{};
  log_pages_ = 0;
  const int code = sqlite3_wal_checkpoint_v2(database_.handle(), nullptr, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
  if (code != SQLITE_OK) return database_.error(code, "move the log of");
  return Nothing{};
}

}  // namespace kerf::store
