#pragma once

// How many random trials a test makes and from which seed, by two variables of the environment:
//   KERF_TRIALS=few|usual|many   few under sanitizers, usual (the default) in deploy/test, many in deploy/test deep
//   KERF_SEED=N                  0 (the default) makes the same trials every time; any other N makes trials of its own
// A failure prints the seed of its trial; KERF_CUT_SEED=<seed> runs that trial alone.

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>

namespace kerf::test {

struct NumTrials {
  int few = 0, usual = 0, many = 0;
};

// The count that KERF_TRIALS names. Aborts on any other word, so that a typing error is not taken for a long run.
inline int num_trials(const NumTrials& counts) {
  const char* named = std::getenv("KERF_TRIALS");  // NOLINT(concurrency-mt-unsafe)
  const std::string word = named == nullptr ? "usual" : named;
  if (word == "few") return counts.few;
  if (word == "usual") return counts.usual;
  if (word == "many") return counts.many;
  std::abort();
}

// KERF_SEED, at most 10^12.
inline std::uint64_t chosen_seed() {
  const char* chosen = std::getenv("KERF_SEED");  // NOLINT(concurrency-mt-unsafe)
  return chosen == nullptr ? 0 : std::strtoull(chosen, nullptr, 10) % 1'000'000'000'001;
}

// The least seed of this run's trials, even: seeds from it on, fewer than ten million, are those of no other KERF_SEED.
inline std::uint64_t first_seed() {
  return 10'000'000 * chosen_seed();
}

// The seed of the one trial that is to be run, if there is one.
inline std::optional<std::uint64_t> only_seed() {
  const char* only = std::getenv("KERF_CUT_SEED");  // NOLINT(concurrency-mt-unsafe)
  if (only == nullptr) return std::nullopt;
  return std::strtoull(only, nullptr, 10);
}

}  // namespace kerf::test
