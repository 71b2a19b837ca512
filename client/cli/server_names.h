#pragma once

#include <string>
#include <vector>

// Asks the server for names, for tab completion and "did you mean". Each function waits at most a quarter of a second
// and returns nothing without an answer by then.
namespace kerf::cli {

std::vector<std::string> sheet_ids(const std::string& address);         // The first 1000, by name.
std::vector<std::string> material_presets(const std::string& address);  // As listed by `kerf info`.

}  // namespace kerf::cli
