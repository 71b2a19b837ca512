#pragma once

#include <string>

#include <CLI/App.hpp>

#include "server/base/result.h"

namespace kerf::cli {

// Reads a file of options for a command: a JSON object whose names are those of the options without "--". Values are
// texts, numbers, true or false, or lists of them for options that may be repeated. Options of the command line win.
// Errors: those of reading the file; INVALID_ARGUMENT BAD_SCENARIO.
Status read_scenario(const CLI::App& command, const std::string& file);

}  // namespace kerf::cli
