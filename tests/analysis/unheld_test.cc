// Static analyses of sheets that nothing holds, and what such analyses leave out.
#include <cmath>

#include "server/core/analysis/analysis.h"
#include "tests/sheet/calls.h"

namespace kerf::analysis {
namespace {

using scene::SheetConfig;
using scenes::flat;

scene::Constraint hold(scene::Region region, bool x, bool y, bool z) {
  scene::Constraint constraint;
  constraint.region = std::move(region);
  constraint.held = {x, y, z};
  return constraint;
}

StaticStats settled(const SheetConfig& config, const scene::StaticAnalysis& analysis = {}) {
  sheet::Sheet sheet = sheet::make(config);
  const Result<Outcome> outcome = run_static(sheet, analysis, {}, {});
  EXPECT_TRUE(outcome.ok());
  return *outcome->statics;
}

TEST(UnheldSheets, AreToldBeforeAnySearch) {
  SheetConfig config = flat(6);
  config.gravity = {0.0, 0.0, -9.81};
  StaticStats stats = settled(config);
  EXPECT_FALSE(stats.converged);
  EXPECT_EQ(stats.load, 0.0);
  EXPECT_EQ(stats.iterations, 0);
  EXPECT_NE(stats.reason.find("nothing holds the sheet"), std::string::npos) << stats.reason;
  EXPECT_NE(stats.reason.find("along z"), std::string::npos) << stats.reason;
  // One vertex held across is not enough, one held along the force is.
  config.constraints = {hold(scene::NearestVertex{{0.5, 1.0}}, true, true, false)};
  EXPECT_NE(settled(config).reason.find("along z"), std::string::npos);
  config.constraints = {hold(scene::NearestVertex{{0.5, 1.0}}, true, true, true)};
  EXPECT_TRUE(settled(config).reason.empty());
}

TEST(UnheldSheets, AreThoseOfPiecesThatACutMakesLoose) {
  SheetConfig config = flat(6);
  config.planar = true;
  config.gravity = {0.0, -9.81, 0.0};
  config.constraints = {hold(scene::RegionEdge::kTop, true, true, true)};
  config.commands = {{2, scenes::line_cut({-0.1, 0.45}, {1.1, 0.45})}};
  scene::StaticAnalysis analysis;
  analysis.loads = {0.5, 1.0};
  const StaticStats stats = settled(config, analysis);
  EXPECT_FALSE(stats.converged);
  EXPECT_EQ(stats.load, 0.5);
  EXPECT_NE(stats.reason.find("nothing holds the piece"), std::string::npos) << stats.reason;
  EXPECT_NE(stats.reason.find("along y"), std::string::npos) << stats.reason;
}

TEST(UnheldSheets, HaveEquilibriaWhereTheirLoadsAreInBalance) {
  SheetConfig config = flat(8);
  config.loads = {{scene::EdgeForce{scene::RegionEdge::kRight, {0.3, 0.0, 0.0}, true}, {}},
                  {scene::EdgeForce{scene::RegionEdge::kLeft, {-0.3, 0.0, 0.0}, true}, {}}};
  const StaticStats stats = settled(config);
  EXPECT_TRUE(stats.converged);
  EXPECT_TRUE(stats.reason.empty());
  EXPECT_TRUE(stats.is_stable) << "it may drift, but nothing drives it away";
  config.loads[1].kind = scene::EdgeForce{scene::RegionEdge::kLeft, {-0.2999, 0.0, 0.0}, true};
  EXPECT_NE(settled(config).reason.find("along x"), std::string::npos);
}

TEST(Stability, TakesFreeMotionsForNeutralWhateverTheSheet) {
  for (const std::int32_t n : {3, 8, 21}) {
    for (const double youngs_modulus : {1.0e4, 4.0e5, 1.0e9, 7.0e10}) {
      SheetConfig config = flat(n);
      config.material = fem::isotropic(youngs_modulus, 0.3, 1.0e-3, 500.0);
      config.analysis = scene::StaticAnalysis{};
      const StaticStats stats = settled(config);
      EXPECT_TRUE(stats.converged) << n << " " << youngs_modulus;
      EXPECT_TRUE(stats.is_stable) << n << " " << youngs_modulus;
    }
  }
}

TEST(Stability, StillTellsWhatBuckles) {
  SheetConfig config = flat(9);
  config.material = fem::isotropic(1.0e6, 0.0, 1.0e-2, 500.0);
  config.constraints = {hold(scene::RegionEdge::kLeft, true, true, true),
                        hold(scene::RegionEdge::kRight, false, true, true)};
  const double critical = 9.8696 * 1.0e6 * 1.0e-6 / 12.0;  // N, Euler: pi^2 E I / L^2, plate of width 1
  for (const double share : {0.9, 1.1}) {
    config.loads = {{scene::EdgeForce{scene::RegionEdge::kRight, {-share * critical, 0.0, 0.0}, true}, {}}};
    const StaticStats stats = settled(config);
    ASSERT_TRUE(stats.converged);
    EXPECT_EQ(stats.is_stable, share < 1.0) << share;
  }
}

TEST(StaticAnalyses, SayWhatTheyLeaveOut) {
  SheetConfig config = flat(4);
  config.constraints = {hold(scene::RegionEdge::kTop, true, true, true)};
  EXPECT_TRUE(settled(config).left_out.empty());
  config.wind.air_density = 1.2;
  EXPECT_TRUE(settled(config).left_out.empty()) << "air at rest pushes nothing that is at rest";
  config.wind.velocity = {3.0, 0.0, 0.0};
  config.colliders = {{contact::Plane{{0.0, 0.0, -1.0}, {0.0, 0.0, 1.0}}, 0.0}};
  EXPECT_EQ(settled(config).left_out, (std::vector<std::string>{"wind", "colliders"}));
  config.self_contact.is_on = true;
  EXPECT_EQ(settled(config).left_out, (std::vector<std::string>{"wind", "colliders", "self_contact"}));
}

}  // namespace
}  // namespace kerf::analysis
