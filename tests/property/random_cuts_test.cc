// Random cuts by the thousand, each audited. A failure prints the seed of its trial; run that one alone with
//   KERF_CUT_SEED=<seed> property_tests --gtest_filter='RandomCuts.*'
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "tests/property/random_cut_trial.h"
#include "tests/support/trials.h"

namespace kerf::property {
namespace {

void expect_sound(std::uint64_t seed, Tally& tally) {
  EXPECT_EQ(run_trial(seed, tally).value_or(""), "") << "KERF_CUT_SEED=" << seed;
}

TEST(RandomCuts, KeepEveryInvariant) {
  Tally tally;
  if (const auto only = test::only_seed()) {
    expect_sound(*only, tally);
    return;
  }
  const int num_cuts = test::num_trials({.few = 600, .usual = 4'000, .many = 50'000});
  // Two thirds of the cuts are singles.
  std::uint64_t single = test::first_seed() + 2;
  std::uint64_t sequence = test::first_seed() + 1;
  while (tally.cuts < num_cuts && !HasFailure()) {
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

// Graded refinement began at the end of the search for a tip that is a point of the mesh: it depended on the start of
// walks.
TEST(RandomCuts, SeedsThatFoundBugs) {
  for (const std::uint64_t seed : {4561U, 6649U, 20185U}) {
    Tally tally;
    EXPECT_EQ(run_trial(seed, tally).value_or(""), "") << "KERF_CUT_SEED=" << seed;
  }
}

}  // namespace
}  // namespace kerf::property
