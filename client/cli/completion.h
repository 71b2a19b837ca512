#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

// Tab completion. The shells ask `kerf __complete WORD...`, which answers from the same CLI::App that reads the command
// line, so that what they offer is never out of date.
namespace kerf::cli {

struct Candidate {
  std::string word;
  std::string description;  // one line; may be empty
};

struct Completion {
  // What the shell adds by itself.
  enum class Paths { kNone, kFiles, kFolders };
  Paths paths = Paths::kNone;
  std::vector<Candidate> candidates;  // each begins with what has been typed of the word
};

// What only a server knows; each of `address` (HOST:PORT). Empty where it does not answer.
struct ServerNames {
  std::function<std::vector<std::string>(const std::string& address)> sheets;     // their ids
  std::function<std::vector<std::string>(const std::string& address)> materials;  // presets
};

// How the last of `words` may go on; the others stand before it. `kerf` itself is not among them. `address`: of the
// server to ask unless --server is among the words.
Completion complete(const CLI::App& app, const std::vector<std::string>& words, const std::string& address,
                    const ServerNames& names);

// What `kerf __complete` prints: "words", "files" or "folders", then a line for each candidate, its word and, after a
// tab, its description.
std::string to_lines(const Completion& completion);

// The script that teaches a shell to ask; empty for a shell other than bash, zsh and fish.
std::string completion_script(const std::string& shell);

}  // namespace kerf::cli
