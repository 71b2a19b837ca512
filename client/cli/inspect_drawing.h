#pragma once

#include <string>

#include "client/cli/drawing_options.h"
#include "client/cli/output.h"

namespace kerf::cli {

// Prints what is in a drawing. `unit`: name or length of its unit; "m": its own. Returns an exit code.
int inspect_drawing(const Session& session, const std::string& file, DrawingArguments choice, const std::string& unit);

}  // namespace kerf::cli
