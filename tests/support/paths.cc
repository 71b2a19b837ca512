#include "tests/support/paths.h"

namespace kerf::test {

std::filesystem::path source_path(std::string_view path) {
  return std::filesystem::path(KERF_SOURCE_DIR) / path;
}

std::filesystem::path built_path(std::string_view path) {
  return std::filesystem::path(KERF_BUILD_DIR) / path;
}

std::filesystem::path program_path(std::string_view name) {
  return std::filesystem::path(KERF_PROGRAM_DIR) / name;
}

}  // namespace kerf::test
