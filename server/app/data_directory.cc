#include <cstdlib>

#include "server/app/config.h"

namespace kerf::app {

std::filesystem::path default_data_directory() {
  // Relative paths in XDG_DATA_HOME are to be ignored, by the XDG Base Directory Specification.
  const char* data = std::getenv("XDG_DATA_HOME");  // NOLINT(concurrency-mt-unsafe): read as the program starts
  if (data != nullptr && std::filesystem::path(data).is_absolute()) return std::filesystem::path(data) / "kerf";
  const char* home = std::getenv("HOME");  // NOLINT(concurrency-mt-unsafe): as above
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".local" / "share" / "kerf";
}

}  // namespace kerf::app
