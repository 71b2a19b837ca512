// Random cuts on sheets that move, through Sheet::apply: what follows from the mesh must follow every cut. A failure
// prints the seed of its trial; run that one alone with
//   KERF_CUT_SEED=<seed> property_tests --gtest_filter='RandomSheetCuts.*'
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/fem/model/model.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/topology.h"
#include "tests/property/moving_sheets.h"
#include "tests/property/random_curves.h"
#include "tests/support/trials.h"

namespace kerf::sheet {
namespace {

using property::PatchMirror;
using property::random_moving_sheet;
using property::stir;

constexpr int kCutsOfASheet = 10;

struct Tally {
  int cuts = 0, applied = 0, strips = 0;
};

void cut_once(SeededRandom& random, const cut::Curve& curve, double scale, Sheet& sheet, Tally& tally) {
  scene::Cut cut;
  cut.curve = curve;
  cut.options.tolerance = std::pow(10.0, random.uniform(-3.0, -1.0));
  cut.options.min_angle_deg = random.uniform(5.0, 25.0);
  cut.options.max_new_triangles = 30'000;
  if (random.below(4) == 0) cut.options.width_m = scale * std::pow(10.0, random.uniform(-4.0, -0.5));
  const fem::Model model_before = sheet.model();
  const fem::State state_before = sheet.state();
  const fem::Momentum momentum = model_before.momentum(state_before);
  const std::uint64_t hash_before = sheet.state_hash();
  const std::vector<scene::Command> commands{cut};
  const TickReport report = sheet.apply(commands);
  ++tally.cuts;
  ASSERT_EQ(sheet.mesh().find_violation(), std::nullopt);
  if (!report.topology_changed) {
    ASSERT_EQ(sheet.state_hash(), hash_before) << "a cut that was not made changed the sheet";
    return;
  }
  ++tally.applied;

  const fem::Model fresh(sheet.mesh(), sheet.config().material);
  ASSERT_EQ(sheet.model().hash(), fresh.hash()) << "the model is not that of the mesh";
  const fem::State& state = sheet.state();
  ASSERT_EQ(state.x.cols(), sheet.mesh().num_vertices());
  ASSERT_TRUE(state.x.allFinite() && state.v.allFinite());
  ASSERT_EQ(report.replies.size(), 1U);
  ASSERT_TRUE(report.replies[0].ok());
  const double removed = report.replies[0]->cut->removed_mass.value_or(0.0);
  ASSERT_NEAR(fresh.masses().total() + removed, model_before.masses().total(), 1e-13 * model_before.masses().total());
  for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
    ASSERT_EQ(fresh.mass()[static_cast<std::size_t>(v)] > 0.0, sheet.mesh().has_material(v));
  }
  if (cut.options.width_m) {
    ++tally.strips;
    return;  // momentum goes with the material
  }
  if (!sheet.pinned_vertices().empty()) return;  // pins take up momentum
  const double speed = state_before.v.colwise().norm().maxCoeff();
  const Eigen::Vector3d gained = fresh.momentum(state).linear - momentum.linear;
  ASSERT_LE(gained.norm(), 1e-13 * fresh.masses().total() * speed) << "of " << momentum.linear.norm();
}

// A trial: a sequence of cuts on one sheet, which moves in between. Its seed is all that it depends on.
void run_trial(std::uint64_t seed, Tally& tally) {
  SCOPED_TRACE("KERF_CUT_SEED=" + std::to_string(seed));
  SeededRandom random(seed);
  property::Frame frame;
  Result<Sheet> made = random_moving_sheet(random, frame);
  ASSERT_TRUE(made.ok()) << made.error().message;
  Sheet sheet = std::move(made).value();
  PatchMirror mirror;
  std::vector<cut::Curve> earlier;
  for (int i = 0; i < kCutsOfASheet && sheet.mesh().num_triangle_slots() < 1'500; ++i) {
    if (random.below(3) == 0) stir(random, frame, sheet);
    earlier.push_back(property::random_curve(random, sheet.mesh(), frame, earlier));
    cut_once(random, earlier.back(), frame.scale, sheet, tally);
    if (random.below(40) == 0) sheet.apply(std::vector<scene::Command>{scene::Reset{}});
    if (::testing::Test::HasFatalFailure()) return;
    if (random.below(3) == 0) continue;  // a viewer may skip versions
    const std::shared_ptr<const Snapshot> snapshot = sheet.snapshot();
    mirror.follow(*snapshot->topology);
    const std::shared_ptr<const Topology> expected = LazyTopology().at(sheet.mesh(), sheet.topology_version());
    ASSERT_EQ(mirror.triangles, expected->triangles);
    ASSERT_EQ(mirror.pieces, expected->pieces);
    ASSERT_EQ(mirror.material_positions, expected->material_positions);
    ASSERT_EQ(snapshot->topology->num_pieces, sheet.mesh().num_pieces());
    ASSERT_EQ(snapshot->topology->num_triangles, sheet.mesh().num_solid_triangles());
  }
}

TEST(RandomSheetCuts, AreFollowedByModelStateAndViewers) {
  Tally tally;
  if (const auto only = test::only_seed()) {
    run_trial(*only, tally);
    return;
  }
  const int num_cuts = test::num_trials({.few = 100, .usual = 400, .many = 4'000});
  for (std::uint64_t seed = test::first_seed() + 1; tally.cuts < num_cuts && !HasFatalFailure(); ++seed) {
    run_trial(seed, tally);
  }
  if (HasFatalFailure()) return;
  std::printf("%d cuts of moving sheets: %d applied, %d strips\n", tally.cuts, tally.applied, tally.strips);
  EXPECT_GT(tally.applied, tally.cuts / 2);
  EXPECT_GT(tally.strips, tally.cuts / 10);
}

}  // namespace
}  // namespace kerf::sheet
