#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Error.hpp>

// "Did you mean": names near one that there is none of.
namespace kerf::cli {

// Those of `names` that `word` may have been meant for, the nearest first, at most three: as typed but for a letter in
// three (left out, too many, wrong, or two swapped), or begun with it.
std::vector<std::string> near_names(const std::string& word, const std::vector<std::string>& names);

// "; did you mean a, b or c?" or nothing.
std::string did_you_mean(const std::vector<std::string>& names);

// What is wrong with a command line, in a line that names the command, what it knows nothing of, and what was near.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

}  // namespace kerf::cli
