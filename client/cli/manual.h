#pragma once

#include <string>
#include <utility>
#include <vector>

#include <CLI/App.hpp>

namespace kerf::cli {

// Holds the parts of a manual page that the CLI::App lacks.
struct ManualText {
  std::string title;        // "kerf"
  std::string summary;      // One line, for NAME.
  std::string description;  // Paragraphs, separated by empty lines.
  // Headings and texts of the last sections. Lines that begin with a blank are shown unchanged.
  std::vector<std::pair<std::string, std::string>> sections;
};

// Returns a page of section 1 for man(1), in the language of man(7), with every visible command, argument and option.
std::string manual_page(const CLI::App& app, const ManualText& text, const std::string& version);

}  // namespace kerf::cli
