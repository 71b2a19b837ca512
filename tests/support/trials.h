#pragma once

// Sets the number of random trials of a test and their seed by two variables of the environment:
//   KERF_TRIALS=few|usual|many   few under sanitizers, usual (the default) in deploy/test, many in deploy/test deep
//   KERF_SEED=N                  0 (the default) makes the same trials every time; any other N makes trials of its own
// A failure prints the seed of its trial; KERF_CUT_SEED=<seed> runs that trial alone.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

namespace kerf::test {

struct NumTrials {
  int few = 0, usual = 0, many = 0;
};

// Ends the program if a variable of the environment is invalid, so that a typing error does not pass unnoticed.
[[noreturn]] inline void refuse(const char* variable, const std::string& value, const char* allowed) {
  std::fprintf(stderr, "%s: say %s, not '%s'\n", variable, allowed, value.c_str());
  std::exit(2);  // NOLINT(concurrency-mt-unsafe): before any thread
}

// Returns the whole number in a variable of the environment, if it is set.
inline std::optional<std::uint64_t> number_of(const char* variable) {
  const char* text = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe)
  if (text == nullptr) return std::nullopt;
  const std::string value = text;
  if (value.empty() || value.size() > 19 || value.find_first_not_of("0123456789") != std::string::npos) {
    refuse(variable, value, "a whole number of at most 19 digits");
  }
  return std::strtoull(text, nullptr, 10);
}

// Returns the number of trials chosen by KERF_TRIALS.
inline int num_trials(const NumTrials& counts) {
  const char* named = std::getenv("KERF_TRIALS");  // NOLINT(concurrency-mt-unsafe)
  const std::string word = named == nullptr ? "usual" : named;
  if (word == "few") return counts.few;
  if (word == "usual") return counts.usual;
  if (word == "many") return counts.many;
  refuse("KERF_TRIALS", word, "few, usual or many");
}

// Returns KERF_SEED modulo 10^12 + 1; 0 if it is not set.
inline std::uint64_t chosen_seed() {
  return number_of("KERF_SEED").value_or(0) % 1'000'000'000'001;
}

// Returns the first seed of this run's trials, an even number. The ten million seeds from it on belong to no other
// KERF_SEED.
inline std::uint64_t first_seed() {
  return 10'000'000 * chosen_seed();
}

// Returns the seed of the only trial to run, if KERF_CUT_SEED is set.
inline std::optional<std::uint64_t> only_seed() {
  return number_of("KERF_CUT_SEED");
}

}  // namespace kerf::test
