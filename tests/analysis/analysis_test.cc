// Analyses of whole scenes: their tables, their order, how they end.
#include "server/core/analysis/analysis.h"

#include <cmath>
#include <numbers>

#include "tests/sheet/calls.h"
#include "tests/support/failing_integrator.h"

namespace kerf::analysis {
namespace {

using Eigen::Vector2d;
using scene::SheetConfig;

// A strip along x, held at its left end, pulled at the right one, in the plane z = 0.
SheetConfig pulled_strip() {
  SheetConfig config = scenes::hanging(4);
  config.mesh = scene::GridSource{11, 3, 1.0, 0.1, scene::GridPattern::kUniformDiagonals, 0};
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins.clear();
  config.gravity.setZero();
  config.planar = true;
  config.material = fem::isotropic(1.0e6, 0.0, 1.0e-3, 1000.0);
  scene::Constraint left;
  left.region = scene::RegionEdge::kLeft;
  config.constraints = {left};
  config.loads = {{scene::EdgeForce{scene::RegionEdge::kRight, {20.0, 0.0, 0.0}, true}, {}}};
  config.probes = {{"end", scene::Quantity::kDisplacement, {}, scene::RegionEdge::kRight, scene::Reduce::kMean, {}}};
  return config;
}

TEST(StaticAnalysis, TablesTheProbesAtEveryLoad) {
  SheetConfig config = pulled_strip();
  sheet::Sheet sheet = sheet::make(config);
  scene::StaticAnalysis analysis;
  analysis.loads = {0.25, 0.5, 1.0};
  double last = -1.0;
  const Result<Outcome> outcome = run_static(sheet, analysis, sheet.config().probes, [&](const Progress& progress) {
    EXPECT_GE(progress.done, last);
    EXPECT_FALSE(progress.what.empty());
    last = progress.done;
    return true;
  });
  ASSERT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome->statics->converged);
  EXPECT_TRUE(outcome->statics->is_stable);
  EXPECT_EQ(outcome->statics->load, 1.0);
  EXPECT_EQ(outcome->statics->solves, 3);
  EXPECT_LE(outcome->statics->residual, analysis.tolerance);
  ASSERT_EQ(outcome->tables.size(), 1U);
  const Table& table = outcome->tables[0];
  EXPECT_EQ(table.columns, (std::vector<std::string>{"load", "end.x", "end.y", "end.z"}));
  ASSERT_EQ(table.rows.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(table.rows[i][0], analysis.loads[i]);
    EXPECT_NEAR(table.rows[i][1], 0.2 * analysis.loads[i], 1e-9);
  }
}

TEST(StaticAnalysis, CutsBeforeTheLoadOfTheirNumber) {
  SheetConfig config = pulled_strip();
  config.commands = {{2, scenes::line_cut({0.5, -0.1}, {0.5, 0.05})}};
  sheet::Sheet sheet = sheet::make(config);
  scene::StaticAnalysis analysis;
  analysis.loads = {0.25, 0.5};
  const Result<Outcome> outcome = run_static(sheet, analysis, sheet.config().probes, {});
  ASSERT_TRUE(outcome.ok());
  ASSERT_EQ(outcome->scheduled.size(), 1U);
  const auto& rows = outcome->tables[0].rows;
  EXPECT_NEAR(rows[0][1], 0.05, 1e-9);
  EXPECT_GT(rows[1][1], 0.102) << "weaker by the cut";
}

TEST(StaticAnalysis, SaysHowFarItCameAndKeepsWhatItFound) {
  SheetConfig config = pulled_strip();
  config.constraints.clear();
  config.loads.push_back({scene::EdgeForce{scene::RegionEdge::kLeft, {-20.0, 0.0, 0.0}, true}, {}});
  // Balanced up to half of the load; nothing holds the strip against what comes then.
  config.loads.push_back(
      {scene::EdgeForce{scene::RegionEdge::kRight, {1.0, 0.0, 0.0}, true}, {{0.5, 1.0}, {0.0, 1.0}}});
  sheet::Sheet sheet = sheet::make(config);
  scene::StaticAnalysis analysis;
  analysis.loads = {0.25, 0.5, 0.75, 1.0};
  analysis.max_iterations = 8;
  const Result<Outcome> outcome = run_static(sheet, analysis, sheet.config().probes, {});
  ASSERT_TRUE(outcome.ok());
  EXPECT_FALSE(outcome->statics->converged);
  EXPECT_NEAR(outcome->statics->load, 0.5, 0.01);
  EXPECT_EQ(outcome->tables[0].rows.size(), 2U);
  EXPECT_FALSE(outcome->stopped);
}

TEST(StaticAnalysis, StopsWhenToldTo) {
  sheet::Sheet sheet = sheet::make(pulled_strip());
  const Result<Outcome> outcome = run_static(sheet, {}, sheet.config().probes, [](const Progress&) { return false; });
  ASSERT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome->stopped);
  EXPECT_FALSE(outcome->statics->converged);
}

TEST(DynamicAnalysis, StopsInTheMiddleOfATickWhenToldTo) {
  SheetConfig config = pulled_strip();
  config.planar = false;
  sheet::Sheet sheet = sheet::make(config);
  scene::DynamicAnalysis analysis;
  analysis.ticks = 5;
  std::vector<std::string> asked;
  const Watch watch = [&](const Progress& progress) {
    asked.push_back(progress.what);
    return progress.done < 0.4 || asked.back() != asked[asked.size() - 4];  // the fourth time in tick 3
  };
  const Result<Outcome> outcome = run_dynamic(sheet, analysis, sheet.config().probes, watch, {}, nullptr);
  ASSERT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome->stopped);
  EXPECT_EQ(outcome->dynamics->ticks, 2);
  EXPECT_EQ(sheet.tick(), 2);
  EXPECT_EQ(outcome->tables[0].rows.size(), 3U) << "at the start, and after each tick";
}

TEST(StaticAnalysis, RefusesAScheduledCommandThatCannotBeDone) {
  SheetConfig config = pulled_strip();
  config.commands = {{1, scene::Drag{"nobody", {0.0, 0.0, 0.0}}}};
  sheet::Sheet sheet = sheet::make(config);
  const Result<Outcome> outcome = run_static(sheet, {}, sheet.config().probes, {});
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.error().field, "commands[0].command.drag.grab_id");
}

// A string: strip without width effects under tension T, f = n / (2 L) sqrt(T / (rho A)) about the loaded state.
TEST(ModalAnalysis, IsAboutTheLoadedState) {
  SheetConfig config = pulled_strip();
  config.planar = false;
  config.material.bending_scale = 0.0;
  config.mesh = scene::GridSource{81, 2, 1.0, 0.0125, scene::GridPattern::kUniformDiagonals, 0};
  scene::Constraint right;
  right.region = scene::RegionEdge::kRight;
  right.displacement = {0.01, 0.0, 0.0};
  config.constraints.push_back(right);
  scene::Constraint flat;  // across the strip, which is not what this is about
  flat.region = scene::WholeSheet{};
  flat.held = {false, true, false};
  config.constraints.push_back(flat);
  config.loads.clear();
  sheet::Sheet sheet = sheet::make(config);
  const Result<Outcome> outcome = run_modes(sheet, {8, scene::StaticAnalysis{}}, sheet.config().probes, {});
  ASSERT_TRUE(outcome.ok()) << outcome.error().message;
  ASSERT_EQ(outcome->tables.size(), 2U);
  const Table& modes = outcome->tables[1];
  EXPECT_EQ(modes.columns, (std::vector<std::string>{"mode", "eigenvalue_per_s2", "frequency_hz"}));
  ASSERT_EQ(modes.rows.size(), 8U);
  for (int n = 1; n <= 3; ++n) {
    const double tension = 1.0e6 * 0.01;                                // Pa
    const double exact = 0.5 * n * std::sqrt(tension / 1000.0 / 1.01);  // Hz; mass and length of the stretched string
    double nearest = 0.0;                                               // among those that twist the strip
    for (const std::vector<double>& mode : modes.rows) {
      if (std::abs(mode[2] - exact) < std::abs(nearest - exact)) nearest = mode[2];
    }
    EXPECT_NEAR(nearest, exact, 2e-3 * exact) << n;
  }
}

TEST(ModalAnalysis, IsOfTheSheetThatCutsOfTheFirstTickMade) {
  SheetConfig config = scenes::hanging(9);
  config.pins.clear();
  config.gravity.setZero();
  const auto lowest = [&config] {  // above the rigid motions, 1/s^2
    sheet::Sheet sheet = sheet::make(config);
    const Result<Outcome> outcome = run_modes(sheet, {8, {}}, config.probes, {});
    EXPECT_TRUE(outcome.ok());
    EXPECT_EQ(outcome->scheduled.size(), config.commands.size());
    return outcome->tables.at(0).rows.at(6)[1];
  };
  const double whole = lowest();
  config.commands = {{1, scenes::line_cut({0.25, 0.5}, {1.2, 0.5})}};
  const double slit = lowest();
  EXPECT_GT(slit, 0.0);
  EXPECT_LT(slit, 0.75 * whole);
}

// Just after its start the cloth is compressed in places. Those five modes lie far from all others, which are near 0.
TEST(ModalAnalysis, FindsAllOfAMovingSheetWhoseModesLieNearZero) {
  SheetConfig config = scenes::flat(24);
  config.gravity = {0.0, 0.0, -9.81};
  config.material.youngs_modulus_1 = config.material.youngs_modulus_2 = 1.5e5;
  config.material.shear_modulus = 1.5e5 / 2.6;
  config.pins = {scene::MaterialBox{{0.0, 0.97}, {0.05, 1.0}}, scene::MaterialBox{{0.95, 0.97}, {1.0, 1.0}}};
  sheet::Sheet sheet = sheet::make(config);
  sheet.step({});
  sheet.step({});
  const Result<Outcome> outcome = run_modes(sheet, {6, {}}, {}, {});
  ASSERT_TRUE(outcome.ok()) << outcome.error().message;
  const std::vector<std::vector<double>>& rows = outcome->tables[0].rows;
  ASSERT_EQ(rows.size(), 6U);
  EXPECT_LT(rows[0][1], -100.0);
  for (std::size_t i = 1; i < rows.size(); ++i) EXPECT_GE(rows[i][1], rows[i - 1][1]);
}

TEST(ModalAnalysis, RefusesMoreModesThanThereAre) {
  SheetConfig config = scenes::hanging(2);
  sheet::Sheet sheet = sheet::make(config);
  const Result<Outcome> outcome = run_modes(sheet, {6, {}}, {}, {});
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.error().reason, "TOO_MANY_MODES");
}

TEST(DynamicAnalysis, TablesTheProbesFromTheStartAndAfterEachTick) {
  SheetConfig config = scenes::hanging(5);
  config.pins.clear();
  config.probes = {{"fall", scene::Quantity::kCentreOfMass, {}, {}, scene::Reduce::kEach, {}}};
  config.integrator.kind = scene::IntegratorKind::kExplicitLeapfrog;
  config.material.mass_damping = 0.0;
  sheet::Sheet sheet = sheet::make(config);
  int reports = 0;
  const Result<Outcome> outcome = run_dynamic(
      sheet, {.ticks = 30}, config.probes, {}, [&](const sheet::TickReport&) { ++reports; }, nullptr);
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(reports, 30);
  const Table& table = outcome->tables.at(0);
  EXPECT_EQ(table.columns.front(), "time_s");
  ASSERT_EQ(table.rows.size(), 31U);
  for (const std::vector<double>& row : table.rows) {
    EXPECT_NEAR(row[3], 0.5 - 0.5 * 9.81 * row[0] * row[0], 1e-9);
  }
}

TEST(DynamicAnalysis, MeasuresEverySoManyTicksAndAtTheEnd) {
  SheetConfig config = scenes::hanging(5);
  config.probes = {{"c", scene::Quantity::kCentreOfMass, {}, {}, scene::Reduce::kEach, {}},
                   {"r", scene::Quantity::kReaction, {}, scene::WholeSheet{}, scene::Reduce::kSum, {}}};
  const auto table_of = [&](const scene::DynamicAnalysis& analysis) {
    sheet::Sheet sheet = sheet::make(config);
    return run_dynamic(sheet, analysis, config.probes, {}, {}, nullptr).value().tables.at(0).rows;
  };
  const auto all = table_of({.ticks = 10});
  ASSERT_EQ(all.size(), 11U);
  const auto some = table_of({.ticks = 10, .measure_every = 4});
  EXPECT_EQ(some, (std::vector<std::vector<double>>{all[0], all[4], all[8], all[10]}));
  EXPECT_EQ(table_of({.ticks = 8, .measure_every = 4}), (std::vector<std::vector<double>>{all[0], all[4], all[8]}));
  EXPECT_EQ(table_of({.ticks = 0}), (std::vector<std::vector<double>>{all[0]}));
}

TEST(DynamicAnalysis, EndsWhereTheSheetFreezesAndCountsItsFlags) {
  SheetConfig config = scenes::hanging(5);
  config.gravity = {0.0, 0.0, scenes::kGivesUp};
  config.probes = {{"e", scene::Quantity::kEnergy, {}, {}, scene::Reduce::kEach, {}}};
  sheet::Sheet sheet = sheet::Sheet::create(config, scenes::make_failing_integrator).value();
  const Result<Outcome> outcome = run_dynamic(sheet, {.ticks = 10}, config.probes, {}, {}, nullptr);
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome->dynamics->ticks, sheet::Sheet::kMaxFailedSteps);
  EXPECT_EQ(outcome->dynamics->simulated, 0.0);
  EXPECT_EQ(outcome->dynamics->flagged_ticks[3], sheet::Sheet::kMaxFailedSteps) << fem::kStepFlagNames[3];
  EXPECT_EQ(outcome->tables.at(0).rows.size(), 1U + sheet::Sheet::kMaxFailedSteps);
}

}  // namespace
}  // namespace kerf::analysis
