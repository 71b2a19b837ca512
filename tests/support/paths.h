#pragma once

#include <filesystem>
#include <string_view>

// Says where sources and built files lie. Only paths.cc is compiled for one place, so a compiler cache has all other
// objects for each copy of the tree.
namespace kerf::test {

/** Returns the path of a source or of test data, given from the root of the repository. */
std::filesystem::path source_path(std::string_view path);
/** Returns the path of a built file, given from the folder of the build. */
std::filesystem::path built_path(std::string_view path);
/** Returns the path of a program of this build. */
std::filesystem::path program_path(std::string_view name);

}  // namespace kerf::test
