#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

#include "server/app/config.h"
#include "server/service/store/check_store.h"
#include "server/service/store/restore_store.h"

namespace kerf::app {

std::filesystem::path default_data_directory() {
  // Relative paths in XDG_DATA_HOME are to be ignored, by the XDG Base Directory Specification.
  const char* data = std::getenv("XDG_DATA_HOME");  // NOLINT(concurrency-mt-unsafe): read as the program starts
  if (data != nullptr && std::filesystem::path(data).is_absolute()) return std::filesystem::path(data) / "kerf";
  const char* home = std::getenv("HOME");  // NOLINT(concurrency-mt-unsafe): as above
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".local" / "share" / "kerf";
}

namespace {

std::string counts_of(const store::StoreInfo& info) {
  return std::to_string(info.sheets) + " sheets, " + std::to_string(info.quarantined.size()) + " set aside, " +
         std::to_string(info.entries) + " changes, " + std::to_string(info.states) + " states, " +
         std::to_string(info.requests) + " answers";
}

}  // namespace

Result<std::variant<Config, Notice>> restore_kept_sheets(const std::string& backup, const std::string& folder) {
  // Without a slash at its end or a link in it, so that the new folder lies beside it.
  std::error_code unknown;
  std::filesystem::path target = std::filesystem::weakly_canonical(folder, unknown);
  if (unknown) target = folder;
  if (target.filename().empty()) target = target.parent_path();
  const Result<store::StoreInfo> restored = store::restore_store(backup, target.string());
  if (!restored.ok()) {
    return invalid_argument(restored.error().reason, "--restore-store: " + restored.error().message, "--restore-store");
  }
  return std::variant<Config, Notice>(
      Notice{"restored " + counts_of(*restored) + " into \"" + target.string() + "\"\n"});
}

Result<std::variant<Config, Notice>> check_kept_sheets(const std::string& folder) {
  const Result<store::StoreReport> report = store::check_store(folder);
  if (!report.ok()) {
    return invalid_argument(report.error().reason, "--check-store: " + report.error().message, "--check-store");
  }
  const store::StoreInfo& info = report->info;
  const std::size_t num_faults = report->faults.size() + report->known_faults.size();
  Notice notice;
  for (const std::string& fault : report->faults) notice.text += "fault: " + fault + "\n";
  for (const std::string& fault : report->known_faults) notice.text += "fault of a sheet set aside: " + fault + "\n";
  for (const std::string& file : report->orphan_files) {
    notice.text += "left over: " + file + ", which nothing names; it may be deleted\n";
  }
  notice.text += counts_of(info) + "; " + std::to_string(num_faults) + " faults\n";
  notice.status = num_faults == 0 ? 0 : 1;
  return std::variant<Config, Notice>(std::move(notice));
}

}  // namespace kerf::app
