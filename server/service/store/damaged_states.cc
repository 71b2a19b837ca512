#include "server/service/store/damaged_states.h"

#include <set>
#include <utility>

#include "server/service/store/schema.h"

namespace kerf::store {
namespace {

// Moves a file of a state out of the way. Returns its path then, or nothing if there is no such file.
Result<std::string> keep_file(Files& files, const std::string& folder, const std::string& name) {
  const std::string from = states_path(folder) + "/" + name;
  const std::string to = damaged_path(folder) + "/" + name;
  if (!files.size(from).ok()) return std::string();
  KERF_TRY(files.make_folder(damaged_path(folder)));
  KERF_TRY(files.rename(from, to));
  KERF_TRY(files.sync_folder(damaged_path(folder)));
  return to;
}

// Keeps files of a sheet that no row names: rows that were damaged may have named them.
Result<std::string> keep_unnamed_files(Tables& tables, Files& files, const std::string& folder, std::int64_t sheet) {
  KERF_TRY_ASSIGN(const std::vector<StateRow> rows, read_state_rows(tables.database(), sheet));
  std::set<std::string> named;
  for (const StateRow& row : rows) named.insert(file_name(row.state));
  KERF_TRY_ASSIGN(const std::vector<std::string> names, files.list(states_path(folder)));
  std::string kept;
  for (const std::string& name : names) {
    if (!name.starts_with(std::to_string(sheet) + "-") || named.contains(name)) continue;
    KERF_TRY_ASSIGN(kept, keep_file(files, folder, name));
  }
  return kept;
}

}  // namespace

Result<std::vector<DamagedState>> set_damaged_states_aside(Tables& tables, Files& files, const std::string& folder,
                                                           std::int64_t sheet) {
  KERF_TRY_ASSIGN(const std::vector<StateRow> rows, read_state_rows(tables.database(), sheet));
  std::vector<DamagedState> damaged;
  for (const auto& [state, is_whole] : rows) {
    if (!is_whole) {
      KERF_TRY(tables.remove_state_row(state));
      KERF_TRY_ASSIGN(std::string file, keep_unnamed_files(tables, files, folder, sheet));
      damaged.push_back({"the row of " + words_for(state) + " has changed", std::move(file)});
      continue;
    }
    const Result<std::string> content = read_content(files, folder, state);
    if (content.ok()) continue;
    DamagedState found{content.error().message, {}};
    if (content.error().code == ErrorCode::kDataLoss) {
      // Moves the file first: where the program ends between the two, the next start finds the row again.
      KERF_TRY_ASSIGN(found.kept_file, keep_file(files, folder, file_name(state)));
      KERF_TRY(tables.remove_state_row(state));
    }
    damaged.push_back(std::move(found));
  }
  return damaged;
}

}  // namespace kerf::store
