#include "server/app/site_folders.h"

#include <string_view>
#include <system_error>

namespace kerf::app {
namespace {

// Returns the folder of a built site: share/kerf/NAME beside the executable's folder, else `built` in a folder above
// it. Empty if neither has an index.html.
std::filesystem::path find_site(const std::filesystem::path& executable, std::string_view name,
                                const std::filesystem::path& built) {
  const auto has_index = [](const std::filesystem::path& folder) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(folder / "index.html", ignored);
  };
  const std::filesystem::path bin = executable.parent_path();
  if (auto installed = bin.parent_path() / "share" / "kerf" / name; has_index(installed)) return installed;
  // Handles build/<preset>/bin/kerfd in a source tree.
  for (std::filesystem::path folder = bin; folder != folder.root_path(); folder = folder.parent_path()) {
    if (auto site = folder / built; has_index(site)) return site;
  }
  return {};
}

}  // namespace

std::filesystem::path default_web_directory(const std::filesystem::path& executable) {
  return find_site(executable, "web", "web/dist");
}

std::filesystem::path default_docs_directory(const std::filesystem::path& executable) {
  return find_site(executable, "docs", "build/docs/site");
}

}  // namespace kerf::app
