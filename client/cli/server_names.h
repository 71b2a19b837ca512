#pragma once

#include <string>
#include <vector>

#include "client/cli/output.h"

// Asks the server for names, for tab completion and "did you mean". Each function waits at most a quarter of a second
// and returns nothing without an answer by then. Nor does it if the server's credentials cannot be used.
namespace kerf::cli {

std::vector<std::string> sheet_ids(const ServerTarget& server);         // The first 1000, by name.
std::vector<std::string> material_presets(const ServerTarget& server);  // As listed by `kerf info`.

}  // namespace kerf::cli
