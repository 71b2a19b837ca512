#pragma once

#include <string>
#include <utility>
#include <vector>

#include <CLI/App.hpp>

namespace kerf::cli {

// What a manual page says beside what the CLI::App knows.
struct ManualText {
  std::string title;        // "kerf"
  std::string summary;      // one line, for NAME
  std::string description;  // paragraphs, an empty line between them
  // Heading and text of what stands at the end. Lines that begin with a blank are shown as they are.
  std::vector<std::pair<std::string, std::string>> sections;
};

// A page of section 1 for man(1), in the language of man(7), with every command, argument and option that is not
// hidden.
std::string manual_page(const CLI::App& app, const ManualText& text, const std::string& version);

}  // namespace kerf::cli
