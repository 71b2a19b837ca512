#include "server/service/store/check_store.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "server/service/store/reading.h"
#include "server/service/store/schema.h"

namespace kerf::store {
namespace {

std::string named(std::int64_t sheet) {
  return "sheet " + std::to_string(sheet);
}

std::string named(const StoredSheet& sheet) {
  return sheet.is_damaged ? named(sheet.sheet) : named(sheet.sheet) + " \"" + sheet.id + "\"";
}

Status check_pages(Database& database, StoreReport& report) {
  KERF_TRY_ASSIGN(Statement rows, Statement::prepare(database, "PRAGMA integrity_check"));
  while (true) {
    KERF_TRY_ASSIGN(const bool is_row, rows.step());
    if (!is_row) return Nothing{};
    if (rows.bytes(0) != "ok") report.faults.emplace_back("the database is damaged: " + std::string(rows.bytes(0)));
  }
}

// Returns the latest number that the oldest entry may have: recovery from the second-last unnamed state needs the one
// after that.
std::int64_t latest_first_seq(const StoredSheet& sheet) {
  std::set<std::int64_t> seqs;
  for (const StateInfo& state : sheet.states) {
    if (state.name.empty()) seqs.insert(state.seq);
  }
  return seqs.size() < 2 ? 1 : *std::next(seqs.rbegin()) + 1;
}

Status check_sheet(Database& database, Files& files, const std::string& folder, const StoredSheet& sheet,
                   StoreReport& report) {
  std::vector<std::string>& faults = sheet.is_quarantined && !sheet.is_damaged ? report.known_faults : report.faults;
  const auto fault = [&](const std::string& text) { faults.push_back(named(sheet) + ": " + text); };
  if (sheet.is_damaged) fault("its row has changed since it was written");
  if (sheet.num_damaged_states > 0) fault("the row of a state has changed since it was written");
  KERF_TRY_ASSIGN(const std::vector<std::string> in_journal, journal_faults(database, sheet));
  for (const std::string& text : in_journal) fault(text);
  for (const StateInfo& state : sheet.states) {
    const Result<std::string> content = read_content(files, folder, state);
    if (!content.ok()) fault(content.error().message);
  }
  return Nothing{};
}

Status check_requests(Database& database, const std::vector<StoredSheet>& sheets, StoreReport& report) {
  KERF_TRY_ASSIGN(const KeptRequests kept, read_requests(database, SIZE_MAX, SIZE_MAX));
  if (kept.num_damaged > 0) {
    report.faults.push_back(std::to_string(kept.num_damaged) + " answers have changed since they were written");
  }
  for (const KeptRequest& one : kept.requests) {
    const auto sheet = std::find_if(sheets.begin(), sheets.end(), [&](const auto& s) { return s.sheet == one.sheet; });
    if (sheet != sheets.end() && one.seq > sheet->last_seq) {
      report.faults.push_back(named(*sheet) + ": entry " + std::to_string(one.seq) + " of request \"" +
                              one.request.key + "\" is not there");
    }
  }
  return Nothing{};
}

Status find_orphans(Files& files, const std::string& folder, const std::vector<StoredSheet>& sheets,
                    StoreReport& report) {
  KERF_TRY_ASSIGN(const std::vector<std::string> names, files.list(states_path(folder)));
  std::set<std::string> expected;
  for (const StoredSheet& sheet : sheets) {
    for (const StateInfo& state : sheet.states) expected.insert(file_name(state));
  }
  std::copy_if(names.begin(), names.end(), std::back_inserter(report.orphan_files), [&](const std::string& name) {
    return name.find(".state") != std::string::npos && !expected.contains(name);
  });
  return Nothing{};
}

Result<StoreReport> check_database(Database& database, Files& files, const std::string& folder) {
  StoreReport report;
  KERF_TRY(check_pages(database, report));
  if (const Status keys = check_keys(database); !keys.ok()) report.faults.push_back(keys.error().message);
  report.opens = report.faults.empty();
  KERF_TRY_ASSIGN(const std::vector<StoredSheet> sheets, read_sheets(database));
  for (const StoredSheet& sheet : sheets) KERF_TRY(check_sheet(database, files, folder, sheet, report));
  KERF_TRY(check_requests(database, sheets, report));
  KERF_TRY(find_orphans(files, folder, sheets, report));
  KERF_TRY_ASSIGN(report.info, read_info(database, files, folder));
  return report;
}

}  // namespace

Result<std::vector<std::string>> journal_faults(Database& database, const StoredSheet& sheet) {
  std::vector<std::string> faults;
  if (sheet.first_seq > latest_first_seq(sheet)) {
    faults.push_back("its oldest entry is " + std::to_string(sheet.first_seq) + ", and entry " +
                     std::to_string(latest_first_seq(sheet)) + " is needed");
  }
  const auto entries = read_entries(database, sheet.sheet, std::max<std::int64_t>(sheet.first_seq, 1) - 1);
  if (!entries.ok()) {
    if (entries.error().reason != "JOURNAL_DAMAGED") return entries.error();
    faults.push_back(entries.error().message);
  }
  for (const StateInfo& state : sheet.states) {
    if (state.seq > sheet.last_seq) {
      faults.push_back("a state follows entry " + std::to_string(state.seq) + ", which is not there");
    }
  }
  return faults;
}

Result<StoreReport> check_store(const std::string& folder, Files& files, const std::string& vfs) {
  std::unique_ptr<FileLock> lock;
  if (files.size(lock_path(folder)).ok() && files.is_writable(lock_path(folder))) {
    KERF_TRY_ASSIGN(lock, files.lock(lock_path(folder)));
  }
  KERF_TRY_ASSIGN(Database database, open_to_read(files, folder, vfs));
  return check_database(database, files, folder);
}

Result<StoreInfo> read_info(Database& database, Files& files, const std::string& folder) {
  StoreInfo info;
  KERF_TRY_ASSIGN(info.sheets, database.number("SELECT count(*) FROM sheets WHERE state <> 2"));
  KERF_TRY_ASSIGN(info.entries, database.number("SELECT count(*) FROM journal"));
  KERF_TRY_ASSIGN(info.requests, database.number("SELECT count(*) FROM requests"));
  KERF_TRY_ASSIGN(info.states, database.number("SELECT count(*) FROM states"));
  KERF_TRY_ASSIGN(info.entry_bytes, database.number("SELECT sum(length(content)) FROM journal"));
  KERF_TRY_ASSIGN(info.state_bytes, database.number("SELECT sum(bytes) FROM states"));
  for (const std::string& path : {database_path(folder), database_path(folder) + "-wal"}) {
    const Result<std::int64_t> bytes = files.size(path);
    if (bytes.ok()) info.database_bytes += *bytes;
  }
  KERF_TRY_ASSIGN(Statement set_aside,
                  Statement::prepare(database, "SELECT sheet, id, reason FROM sheets WHERE state = 1 ORDER BY sheet"));
  while (true) {
    KERF_TRY_ASSIGN(const bool is_row, set_aside.step());
    if (!is_row) return info;
    info.quarantined.push_back(
        {set_aside.integer(0), std::string(set_aside.bytes(1)), std::string(set_aside.bytes(2))});
  }
}

}  // namespace kerf::store
