#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "server/app/config.h"
#include "server/service/store/check_store.h"
#include "server/service/store/restore_store.h"

namespace kerf::app {

std::filesystem::path made_absolute(std::filesystem::path path) {
  std::error_code unknown;
  std::filesystem::path found = std::filesystem::absolute(path, unknown);
  return unknown ? std::move(path) : found.lexically_normal();
}

std::filesystem::path default_data_directory() {
  // Relative paths in XDG_DATA_HOME are to be ignored, by the XDG Base Directory Specification.
  const char* data = std::getenv("XDG_DATA_HOME");  // NOLINT(concurrency-mt-unsafe): read as the program starts
  if (data != nullptr && std::filesystem::path(data).is_absolute()) return std::filesystem::path(data) / "kerf";
  const char* home = std::getenv("HOME");  // NOLINT(concurrency-mt-unsafe): as above
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".local" / "share" / "kerf";
}

namespace {

std::string counted(std::int64_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string counts_of(const store::StoreInfo& info) {
  return counted(info.sheets, "sheet") + ", " + std::to_string(info.quarantined.size()) + " set aside, " +
         counted(info.entries, "change") + ", " + counted(info.states, "state") + ", " +
         counted(info.requests, "answer");
}

std::string faults_of(const store::StoreReport& report) {
  std::string text;
  for (const std::string& fault : report.faults) text += "fault: " + fault + "\n";
  for (const std::string& fault : report.known_faults) text += "fault of a sheet set aside: " + fault + "\n";
  return text;
}

// Returns the path without links, dots or a slash at its end, where that is known.
std::filesystem::path made_canonical(const std::filesystem::path& path) {
  std::error_code unknown;
  std::filesystem::path found = std::filesystem::weakly_canonical(path, unknown);
  if (unknown) found = path;
  return found.filename().empty() ? found.parent_path() : found;
}

bool is_within(const std::filesystem::path& path, const std::filesystem::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

Error in_option(const char* option, const Error& error) {
  return invalid_argument(error.reason, std::string(option) + ": " + error.message, option);
}

}  // namespace

Status check_backups_directory(const std::filesystem::path& backups, const std::filesystem::path& data) {
  const std::filesystem::path folder = made_canonical(backups);
  const std::filesystem::path kept = made_canonical(data);
  const auto refuse = [&](const std::string& how) {
    return invalid_argument("BAD_BACKUPS_DIR", "--backups: \"" + backups.string() + "\" " + how, "--backups");
  };
  if (folder == kept || is_within(folder, kept / "states") || is_within(folder, kept / "damaged")) {
    return refuse("is used by the store itself; name another folder, such as \"" + (kept / "backups").string() + "\"");
  }
  if (folder == kept.parent_path()) return refuse("has the folder of --data in it; name a folder for backups alone");
  std::filesystem::path there = folder;
  std::error_code broken;
  while (!std::filesystem::exists(there, broken) && there.has_relative_path()) there = there.parent_path();
  if (!std::filesystem::is_directory(there, broken))
    return refuse("cannot be a folder: \"" + there.string() + "\" is none");
  if (::access(there.c_str(), W_OK | X_OK) != 0) {
    return refuse("cannot be written: \"" + there.string() + "\": " + std::generic_category().message(errno));
  }
  return Nothing{};
}

Result<std::variant<Config, Notice>> restore_kept_sheets(const std::string& backup, const std::string& folder) {
  const std::filesystem::path target = made_canonical(folder);
  if (is_within(target, made_canonical(backup))) {
    return invalid_argument("RESTORE_INTO_ITSELF",
                            "--data: \"" + folder + "\" lies in the backup itself; name a folder elsewhere", "--data");
  }
  std::error_code missing;
  if (std::filesystem::exists(target, missing) && !std::filesystem::is_directory(target, missing)) {
    return invalid_argument("BAD_DATA_DIR",
                            "--data: \"" + folder + "\" is no folder; name one that is missing or empty", "--data");
  }
  const Result<store::StoreReport> restored = store::restore_store(backup, target.string());
  if (!restored.ok()) return in_option("--restore-store", restored.error());
  Notice notice;
  notice.text = faults_of(*restored);
  notice.text += "restored " + counts_of(restored->info) + " into \"" + target.string() + "\"\n";
  if (!restored->faults.empty()) {
    notice.text += "What is damaged was copied as it is: kerfd sets it aside. An older backup may have it whole.\n";
    notice.status = 1;
  }
  return std::variant<Config, Notice>(std::move(notice));
}

Result<std::variant<Config, Notice>> check_kept_sheets(const std::string& folder) {
  const Result<store::StoreReport> report = store::check_store(folder);
  if (!report.ok()) return in_option("--check-store", report.error());
  const store::StoreInfo& info = report->info;
  const std::size_t num_faults = report->faults.size() + report->known_faults.size();
  Notice notice;
  notice.text = faults_of(*report);
  for (const std::string& file : report->orphan_files) {
    notice.text += "left over: " + file + ", which nothing names; it may be deleted\n";
  }
  notice.text += counts_of(info) + "; " + counted(static_cast<std::int64_t>(num_faults), "fault") + "\n";
  notice.status = num_faults == 0 ? 0 : 1;
  return std::variant<Config, Notice>(std::move(notice));
}

}  // namespace kerf::app
