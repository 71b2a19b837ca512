// Losses of power at each operation of the disk: nothing that was answered is lost, doubled or changed.

#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "tests/store/power_trial.h"
#include "tests/support/trials.h"

namespace kerf::test {
namespace {

constexpr std::int64_t kPowerStays = std::numeric_limits<std::int64_t>::max();

// Counts trials that broke a promise, out of all losses of power of some workloads.
int count_broken(PowerFault fault, std::uint64_t num_workloads) {
  int broken = 0;
  for (std::uint64_t seed = 1; seed <= num_workloads; ++seed) {
    const std::int64_t operations = run_power_trial(seed, kPowerStays).num_operations;
    for (std::int64_t at = 1; at <= operations; ++at) broken += run_power_trial(seed, at, fault).losses.empty() ? 0 : 1;
  }
  return broken;
}

TEST(Power, ATrialDoesTheSameEachTime) {
  const PowerRun first = run_power_trial(5, kPowerStays);
  EXPECT_GT(first.num_operations, 50);
  EXPECT_GT(first.num_answered, 5);
  for (const std::int64_t ends : {kPowerStays, std::int64_t{60}}) {
    const PowerRun one = run_power_trial(5, ends);
    const PowerRun other = run_power_trial(5, ends);
    EXPECT_EQ(one.num_operations, other.num_operations);
    EXPECT_EQ(one.num_answered, other.num_answered);
  }
}

// Each trial loses power three times.
TEST(Power, NothingAnsweredIsLost) {
  const int num_trials = test::num_trials({.few = 60, .usual = 700, .many = 7000});
  int trials = 0;
  for (std::uint64_t seed = first_seed(); trials < num_trials; ++seed) {
    const std::int64_t operations = run_power_trial(seed, kPowerStays).num_operations;
    for (std::int64_t at = 1; at <= operations && trials < num_trials; ++at, ++trials) {
      const PowerRun run = run_power_trial(seed, at);
      ASSERT_TRUE(run.losses.empty()) << "seed " << seed << ", power ends before operation " << at << ": "
                                      << run.losses.front();
    }
  }
}

TEST(Power, AStoreThatForgetsToSyncItsFolderLoses) {
  EXPECT_GT(count_broken(PowerFault::kNoFolderSync, 1), 0);
}

TEST(Power, ALogThatIsNotSyncedLoses) {
  EXPECT_GT(count_broken(PowerFault::kNoLogSync, 1), 0);
}

}  // namespace
}  // namespace kerf::test
