#include "client/cli/suggestions.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <utility>

#include "client/cli/app.h"

namespace kerf::cli {
namespace {

// Computes the optimal string alignment distance: insertions, deletions, substitutions and swaps of neighbours cost 1
// each.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::array<std::vector<std::size_t>, 3> rows;  // Rows for a's first i - 2, i - 1 and i letters.
  rows[1].resize(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) rows[1][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    rows[2].assign(b.size() + 1, i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = rows[1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      rows[2][j] = std::min({rows[1][j] + 1, rows[2][j - 1] + 1, substituted});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) rows[2][j] = std::min(rows[2][j], rows[0][j - 2] + 1);
    }
    rows[0] = std::move(rows[1]);
    rows[1] = std::move(rows[2]);
  }
  return rows[1][b.size()];
}

std::vector<std::string> option_names(const CLI::App* command) {
  std::vector<std::string> names;
  for (; command != nullptr; command = command->get_parent()) {
    for (const CLI::Option* option : options_of(*command)) names.push_back(option_name(*option));
  }
  return names;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands_of(app)) names.push_back(command->get_name());
  return names;
}

// Returns the given command, as far as it was recognised.
const CLI::App& given_command(const CLI::App& app) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().back();
  return *command;
}

// Returns an unknown option, or else the first extra word; empty if every word was recognised.
std::string unknown_word(const CLI::App& app) {
  const std::vector<std::string> words = app.remaining(true);
  const auto option =
      std::find_if(words.begin(), words.end(), [](const std::string& word) { return word.rfind('-', 0) == 0; });
  if (option != words.end()) return option->substr(0, option->find('='));
  return words.empty() ? std::string() : words.front();
}

// Words of other programs, each with the equivalent command.
constexpr std::array<std::pair<std::string_view, std::string_view>, 18> kOtherNames{{
    {"snip", "cut"},
    {"slice", "cut"},
    {"split", "cut"},
    {"slit", "cut"},
    {"new", "create"},
    {"add", "create"},
    {"make", "create"},
    {"remove", "delete"},
    {"del", "delete"},
    {"show", "get"},
    {"status", "info"},
    {"stop", "pause"},
    {"start", "resume"},
    {"draw", "render"},
    {"screenshot", "render"},
    {"follow", "watch"},
    {"save", "export"},
    {"benchmark", "load"},
}};

// Returns names similar to the word, or else the equivalent command.
std::vector<std::string> near_commands(const std::string& word, const std::vector<std::string>& commands) {
  std::vector<std::string> near = near_names(word, commands);
  for (const auto& [other, name] : kOtherNames) {
    const bool there = std::find(commands.begin(), commands.end(), name) != commands.end();
    if (near.empty() && word == other && there) near.emplace_back(name);
  }
  return near;
}

}  // namespace

std::vector<std::string> near_names(const std::string& word, const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 3;
  std::vector<std::pair<std::size_t, std::string>> near;
  for (const std::string& name : names) {
    const bool begun = word.size() >= 2 && name.compare(0, word.size(), word) == 0;
    const std::size_t distance = begun ? 1 : edit_distance(word, name);
    if (distance <= std::max<std::size_t>(1, std::min(word.size(), name.size()) / 3)) near.emplace_back(distance, name);
  }
  std::sort(near.begin(), near.end());
  near.resize(std::min(near.size(), kMost));
  std::vector<std::string> sorted;
  for (auto& [distance, name] : near) sorted.push_back(std::move(name));
  return sorted;
}

std::string did_you_mean(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
    text += names[i];
  }
  return text.empty() ? text : "; did you mean " + text + "?";
}

std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = given_command(app);
  const std::string name = "`" + full_name(command);
  const std::string help = "\nRun " + name + " --help` for help.";
  const std::string word = unknown_word(app);
  if (word.empty()) return error.what() + help;
  if (word.front() == '-') {
    return name + "` has no option " + word + did_you_mean(near_names(word, option_names(&command))) + help;
  }
  const std::vector<std::string> commands = command_names(command);
  if (commands.empty()) return name + "` takes no further argument: \"" + word + "\"" + help;
  return name + "` has no command \"" + word + "\"" + did_you_mean(near_commands(word, commands)) + help;
}

}  // namespace kerf::cli
