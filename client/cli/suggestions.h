#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Error.hpp>

// Implements "did you mean": names similar to an unknown one.
namespace kerf::cli {

// Returns at most three of `names` that `word` may mean, the nearest first. Each begins with `word` or differs from it
// in at most one letter in three: missing, extra, wrong, or two swapped.
std::vector<std::string> near_names(const std::string& word, const std::vector<std::string>& names);

// Returns "; did you mean a, b or c?" or an empty text.
std::string did_you_mean(const std::vector<std::string>& names);

// Explains a usage error in a line that names the command, the unknown word and similar names.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

}  // namespace kerf::cli
