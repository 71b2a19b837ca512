#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "client/cli/output.h"

// Implements tab completion. The shells run `kerf __complete WORD...`. Its answer comes from the same CLI::App that
// parses the command line, so that it is never out of date.
namespace kerf::cli {

struct Candidate {
  std::string word;
  std::string description;  // One line; may be empty.
};

struct Completion {
  // Names of files or folders, which the shell adds itself.
  enum class Paths { kNone, kFiles, kFolders };
  Paths paths = Paths::kNone;
  std::vector<Candidate> candidates;  // Each begins with the typed part of the word.
};

// Holds functions that ask a server for names. They return none if it does not answer.
struct ServerNames {
  std::function<std::vector<std::string>(const ServerTarget& server)> sheets;     // IDs of sheets.
  std::function<std::vector<std::string>(const ServerTarget& server)> materials;  // Names of presets.
};

// Returns completions of the last of `words`; the others precede it, without `kerf` itself. `server`: the server to
// ask; --server, --token-file and the options of TLS among the words change it.
Completion complete(const CLI::App& app, const std::vector<std::string>& words, const ServerTarget& server,
                    const ServerNames& names);

// Returns the output of `kerf __complete`: "words", "files" or "folders", then a line per candidate. Each line has the
// word and, after a tab, its description.
std::string to_lines(const Completion& completion);

// Returns the completion script of a shell; empty for shells other than bash, zsh and fish.
std::string completion_script(const std::string& shell);

}  // namespace kerf::cli
