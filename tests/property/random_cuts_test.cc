// 50,000 random cuts, each audited. A failure prints the seed of its trial; run that one alone with
//   KERF_CUT_SEED=<seed> random_cuts_test
#include <cstdio>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "tests/property/random_cut_trial.h"

#ifndef KERF_RANDOM_CUTS
#define KERF_RANDOM_CUTS 50000
#endif

namespace kerf::property {
namespace {

void expect_sound(std::uint64_t seed, Tally& tally) {
  EXPECT_EQ(run_trial(seed, tally).value_or(""), "") << "KERF_CUT_SEED=" << seed;
}

TEST(RandomCuts, KeepEveryInvariant) {
  Tally tally;
  if (const char* only = std::getenv("KERF_CUT_SEED")) {
    expect_sound(std::strtoull(only, nullptr, 10), tally);
    return;
  }
  // Two thirds of the cuts are singles.
  std::uint64_t single = 2;
  std::uint64_t sequence = 1;
  while (tally.cuts < KERF_RANDOM_CUTS && !HasFailure()) {
    for (int i = 0; i < 2 * kCutsOfASequence / kSingles && !HasFailure(); ++i, single += 2) expect_sound(single, tally);
    if (HasFailure()) break;
    expect_sound(sequence, tally);
    sequence += 2;
  }
  std::printf(
      "%lld cuts: %lld applied, %lld missed, %lld degenerate, refinement stopped in %lld, %lld strips; area drift "
      "%.1e\n",
      static_cast<long long>(tally.cuts), static_cast<long long>(tally.applied), static_cast<long long>(tally.missed),
      static_cast<long long>(tally.invalid), static_cast<long long>(tally.stopped),
      static_cast<long long>(tally.strips), tally.area_drift);
  for (const auto& [reason, count] : tally.refused) ADD_FAILURE() << count << " refused: " << reason;
  EXPECT_GT(tally.applied, tally.cuts * 3 / 5);
  EXPECT_LE(tally.invalid, tally.cuts / 100);
}

// Where the search for a tip that is a point of the mesh ended, graded refinement began: it depended on what walks
// start from.
TEST(RandomCuts, SeedsThatFoundBugs) {
  for (const std::uint64_t seed : {4561U, 6649U, 20185U}) {
    Tally tally;
    EXPECT_EQ(run_trial(seed, tally).value_or(""), "") << "KERF_CUT_SEED=" << seed;
  }
}

}  // namespace
}  // namespace kerf::property
