#pragma once

#include <filesystem>

namespace kerf::app {

// Returns the default folder of the built viewer. That is share/kerf/web beside the executable's folder, the place of
// `cmake --install`, else web/dist of a source tree above the executable. Empty if neither has an index.html.
std::filesystem::path default_web_directory(const std::filesystem::path& executable);
// Returns the default folder of the built documentation: share/kerf/docs beside the executable's folder, else
// build/docs/site of a source tree above it. Empty if neither has an index.html.
std::filesystem::path default_docs_directory(const std::filesystem::path& executable);

}  // namespace kerf::app
