#pragma once

#include <string>
#include <vector>

// Names that only a server knows, for tab completion and "did you mean". Each asks for at most a quarter of a second,
// and is empty where no server answers by then.
namespace kerf::cli {

std::vector<std::string> sheet_ids(const std::string& address);         // the first 1000, by name
std::vector<std::string> material_presets(const std::string& address);  // as `kerf info` lists them

}  // namespace kerf::cli
