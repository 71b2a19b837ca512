#include "server/service/store/damaged_states.h"

#include <set>
#include <utility>

#include "server/service/store/schema.h"

namespace kerf::store {
namespace {

// Moves a file of a state out of the way, and returns its path then. Error kNotFound if there is no such file.
Result<std::string> keep_file(Files& files, const std::string& folder, const std::string& name) {
  const std::string from = states_path(folder) + "/" + name;
  const std::string to = damaged_path(folder) + "/" + name;
  KERF_TRY(files.size(from));
  KERF_TRY(files.make_folder(damaged_path(folder)));
  KERF_TRY(files.rename(from, to));
  KERF_TRY(files.sync_folder(damaged_path(folder)));
  return to;
}

// Keeps files of a sheet that no row which is whole names: damaged ones may have named them. Returns the path of the
// last.
Result<std::string> keep_unnamed_files(Files& files, const std::string& folder, std::int64_t sheet,
                                       const std::vector<StateRow>& rows) {
  std::set<std::string> named;
  for (const StateRow& row : rows) {
    if (row.is_whole) named.insert(file_name(row.state));
  }
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
    const Result<std::string> content =
        is_whole ? read_content(files, folder, state)
                 : Result<std::string>(data_loss("STATE_DAMAGED", "the row of " + words_for(state) + " has changed"));
    if (content.ok()) continue;
    damaged.push_back({content.error().message, {}});
    if (content.error().code != ErrorCode::kDataLoss) continue;
    // Moves files first: where the program ends between the two, the next start finds the row again. So it does where
    // they cannot be moved.
    Result<std::string> kept =
        is_whole ? keep_file(files, folder, file_name(state)) : keep_unnamed_files(files, folder, sheet, rows);
    if (kept.ok()) {
      damaged.back().kept_file = std::move(*kept);
    } else if (kept.error().code != ErrorCode::kNotFound) {
      damaged.back().reason += "; it stays, as this server " + kept.error().message;
      continue;
    }
    KERF_TRY(tables.remove_state_row(state));
  }
  return damaged;
}

}  // namespace kerf::store
