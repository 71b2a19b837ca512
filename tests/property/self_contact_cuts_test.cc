// Tests that a sheet with self-contact never passes through itself after random cuts, and gains no energy. A failure
// prints the seed of its trial; run that one alone with
//   KERF_CUT_SEED=<seed> property_tests --gtest_filter='SelfContactCuts.*'
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "server/core/sheet/sheet.h"
#include "tests/support/self_contact_scenes.h"
#include "tests/support/trials.h"

namespace kerf::property {
namespace {

using sheet::Sheet;
using sheet::TickReport;

constexpr std::int32_t kSide = 12;  // vertices along a side
constexpr std::size_t kCuts = 12;
constexpr int kTicks = 45;  // it reaches the floor after 24

Sheet touching(scene::SheetConfig config) {
  config.self_contact.is_on = true;
  return Sheet::create(std::move(config)).value();
}

// Random cuts at once of a sheet that then falls on a floor.
void drop_after_cuts(std::uint64_t seed) {
  SCOPED_TRACE("KERF_CUT_SEED=" + std::to_string(seed));
  Sheet sheet = touching(scenes::falls_after_cuts(kSide, seed, kCuts));
  sheet.step({});
  double energy = sheet.energies().total();
  const double allowed = 1e-5 * energy;  // J, of what it has above the floor
  for (int i = 1; i < kTicks; ++i) {
    const TickReport report = sheet.step({});
    ASSERT_FALSE(report.frozen);
    ASSERT_EQ(report.stats.self_contact.intersections, 0) << "after tick " << i + 1;
    const double now = sheet.energies().total();
    ASSERT_LE(now, energy + allowed) << "in tick " << i + 1;
    energy = now;
  }
}

void for_each_seed(const test::NumTrials& counts, const std::function<void(std::uint64_t)>& run) {
  if (const auto only = test::only_seed()) return run(*only);
  const auto num = static_cast<std::uint64_t>(test::num_trials(counts));
  for (std::uint64_t k = 0; k < num; ++k) run(test::first_seed() + k);
}

TEST(SelfContactCuts, ASheetThatFallsAfterRandomCutsPassesThroughNothing) {
  for_each_seed({1, 6, 40}, drop_after_cuts);
}

}  // namespace
}  // namespace kerf::property
