#pragma once

#include <string>
#include <vector>

namespace kerf::load {

// Returns a whole page without scripts or other files, light or dark as the reader's system is. `body` is HTML.
[[nodiscard]] std::string html_page(const std::string& title, const std::string& body);
// Returns a row of a table; cells are escaped. `tag`: "td" or "th".
[[nodiscard]] std::string html_row(const std::vector<std::string>& cells, const char* tag = "td");

}  // namespace kerf::load
