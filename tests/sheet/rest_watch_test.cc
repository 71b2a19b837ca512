#include "server/core/sheet/rest_watch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "server/core/fem/model/tick_cost.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector3d;

// Ticks until it is at rest, or `most`.
int ticks_to_rest(Sheet& sheet, int most) {
  for (int tick = 1; tick <= most; ++tick) {
    if (sheet.step({}).at_rest) return tick;
  }
  return most;
}

// m, how far any vertex goes in the minute to come.
double motion_in_a_minute(Sheet sheet) {
  const Eigen::Matrix3Xd from = sheet.state().x;
  double largest = 0.0;
  for (int tick = 0; tick < 3600; ++tick) {
    sheet.step({});
    largest = std::max(largest, (sheet.state().x - from).colwise().norm().maxCoeff());
  }
  return largest;
}

struct Case {
  std::string_view name;
  scene::SheetConfig config;
};

std::vector<Case> sheets_that_come_to_rest() {
  std::vector<Case> cases{{"pinned at its top", scenes::hanging(12)},
                          {"draped over a ball", scenes::draped_over_sphere(20)},
                          {"on the floor", scenes::lying_on_floor(10)},
                          {"a coarse one over a ball", scenes::draped_over_sphere(14)},
                          {"skin over a ball", scenes::draped_over_sphere(12)},
                          {"cotton over a ball", scenes::draped_over_sphere(12)},
                          {"skin over a box", scenes::draped_over_sphere(20)}};
  const auto find = [&](std::string_view name) -> scene::SheetConfig& {
    return std::ranges::find(cases, name, &Case::name)->config;
  };
  find("skin over a ball").material = find("skin over a box").material = fem::find_preset("skin").value();
  find("cotton over a ball").material = fem::find_preset("cotton").value();
  contact::OrientedBox box;
  box.centre = {0.0, 0.0, 0.1};
  box.half_extents = {0.25, 0.3, 0.2};
  find("skin over a box").colliders = {{box, 0.4}};
  return cases;
}

// The window at whose end a vertex, which is at position(t) on a line (m), has moved for `length` (s).
template <typename Position>
MotionWindow watched(double length, const Position& position) {
  constexpr double kTick = 1.0 / 60.0;
  const auto at = [&](double t) { return Eigen::Matrix3Xd(Vector3d(position(t), 0.0, 0.0)); };
  MotionWindow window(length);
  window.make_room(1);
  window.begin(at(0.0));
  for (double t = kTick; !window.add(at(t), kTick); t += kTick) {
  }
  return window;
}

TEST(MotionWindow, WhatTremblesAndCreepsStaysWithinItsExtentAndDrift) {
  constexpr double kSwing = 1e-3, kDrift = 1e-4;  // m, m/s
  const MotionWindow window =
      watched(8.0, [](double t) { return kSwing * std::sin(1.5 * std::numbers::pi * t) + kDrift * t; });
  EXPECT_TRUE(window.stays_within(2.0 * kSwing + 8.0 * kDrift, 1.1 * kDrift));
  EXPECT_FALSE(window.stays_within(2.0 * kSwing + 8.0 * kDrift, 0.9 * kDrift));
  EXPECT_FALSE(window.stays_within(kSwing, 1.1 * kDrift));
}

TEST(MotionWindow, WhatCreepsToItsRestMovesByNoMoreThanExpected) {
  for (const double time : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    const MotionWindow window = watched(2.0, [&](double t) { return std::exp(-t / time); });
    const double left = std::exp(-2.0 / time);
    EXPECT_GT(window.expected_motion(60.0, true), left) << time;
    EXPECT_LT(window.expected_motion(60.0, true), window.expected_motion(60.0, false)) << time;
  }
}

TEST(MotionWindow, WhatSwingsMovesByNoMoreThanExpectedWhereverTheWindowBegins) {
  constexpr double kLength = 2.0;                   // s
  for (const double rate : {3.0, 4.0, 5.0, 9.0}) {  // rad/s; from RestWatch::kSwing on, over the window
    for (int i = 0; i < 24; ++i) {
      const auto position = [&](double t) { return std::sin(rate * t + i * std::numbers::pi / 12.0); };
      const double to_come = 1.0 + std::abs(position(kLength));
      EXPECT_GE(watched(kLength, position).expected_motion(60.0, true), to_come) << rate << ", " << i;
    }
  }
}

TEST(MotionWindow, LongTicksLeaveNoThirdOut) {
  MotionWindow window(2.0);
  window.make_room(1);
  window.begin(Eigen::Matrix3Xd::Zero(3, 1));
  int ticks = 1;
  while (!window.add(Eigen::Matrix3Xd::Zero(3, 1), 1.0)) ++ticks;
  EXPECT_EQ(ticks, 3);
}

TEST(MotionWindow, WhatKeepsItsPaceIsExpectedToKeepIt) {
  const MotionWindow window = watched(2.0, [](double t) { return 1.0e-6 * t; });
  EXPECT_NEAR(window.expected_motion(60.0, true), 6.2e-5, 1.0e-7);
  EXPECT_NEAR(window.expected_motion(60.0, false), 6.2e-5, 1.0e-7);
}

TEST(RestWatch, NoSheetSleepsThatWouldMoveByATenthOfAMillimetreWithinAMinute) {
  constexpr int kTwentySeconds = 1200;
  for (const auto& [name, config] : sheets_that_come_to_rest()) {
    Sheet sheet = make(config);
    EXPECT_LT(ticks_to_rest(sheet, 2 * kTwentySeconds), kTwentySeconds) << name;
    EXPECT_LT(motion_in_a_minute(sheet), 1.0e-4) << name;
  }
}

TEST(RestWatch, ASheetThatIsCutComesToRestAgain) {
  Sheet sheet = make(scenes::draped_over_sphere(20));
  ticks_to_rest(sheet, 2400);
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.2, -0.1}, {0.45, 0.6})).ok());
  EXPECT_FALSE(sheet.at_rest());
  EXPECT_LT(ticks_to_rest(sheet, 2400), 1200);
  EXPECT_LT(motion_in_a_minute(sheet), 1.0e-4);
}

TEST(RestWatch, ChangesNothingInTheFirstFiveSecondsNorWhereTheSceneSaysSo) {
  scene::SheetConfig config = scenes::hanging(8);
  scene::SheetConfig free_config = config;
  free_config.rest_damping = false;
  Sheet sheet = make(config);
  Sheet free_sheet = make(free_config);
  run(sheet, 300);
  run(free_sheet, 300);
  EXPECT_EQ(sheet.shape_hash(), free_sheet.shape_hash());
  run(sheet, 900);
  run(free_sheet, 900);
  EXPECT_LT(sheet.energies().kinetic, 0.1 * free_sheet.energies().kinetic);
}

TEST(RestWatch, StepsADrapeAsEverWhereTheSceneSaysSo) {
  scene::SheetConfig config = scenes::draped_over_sphere(8);
  config.rest_damping = false;
  Sheet sheet = make(config);
  int most_before = 0;
  int most_after = 0;
  for (int tick = 1; tick <= 900; ++tick) {
    const int substeps = sheet.step({}).stats.substeps;
    (tick <= 300 ? most_before : most_after) = std::max(tick <= 300 ? most_before : most_after, substeps);
  }
  EXPECT_LE(most_after, most_before);
}

// Calm steps cost more than those of a sheet that a cut has woken.
TEST(RestWatch, ACutIsNotExpectedToCostWhatACalmSheetDoes) {
  Sheet sheet = make(scenes::draped_over_sphere(20));
  run(sheet, 300);
  const double awake = sheet.expected_cost().substeps;
  run(sheet, 900);
  EXPECT_GE(sheet.expected_cost().substeps, 1.4 * awake);
  ASSERT_TRUE(apply(sheet, scene::SetGravity{{0.0, 0.0, -9.0}}).ok());
  EXPECT_LT(sheet.expected_cost().substeps, 1.1 * awake);
}

TEST(RestWatch, DampsNoSheetWithoutDampingOfItsOwnThatTouchesNothing) {
  scene::SheetConfig config = scenes::hanging(8);
  config.material.mass_damping = 0.0;
  config.material.stiffness_damping = 0.0;
  scene::SheetConfig free_config = config;
  free_config.rest_damping = false;
  Sheet sheet = make(config);
  Sheet free_sheet = make(free_config);
  run(sheet, 900);
  run(free_sheet, 900);
  EXPECT_EQ(sheet.shape_hash(), free_sheet.shape_hash());
}

TEST(RestWatch, AStillSheetRestsAfterAWindowAndIsWokenByWhatChangesIt) {
  scene::SheetConfig config = scenes::flat(6);
  config.gravity = Vector3d::Zero();
  Sheet sheet = make(config);
  EXPECT_LE(ticks_to_rest(sheet, 600), 123);
  ASSERT_TRUE(apply(sheet, scene::SetGravity{{0.0, 0.0, -1.0}}).ok());
  EXPECT_FALSE(sheet.at_rest());
  run(sheet, 30);
  EXPECT_FALSE(sheet.at_rest());
}

TEST(RestWatch, ASlowDriftIsNoRest) {
  scene::SheetConfig config = scenes::flat(5);
  config.gravity = Vector3d::Zero();
  config.pins.clear();
  config.material.mass_damping = 0.0;
  config.initial_velocity = scene::InitialVelocity{Vector3d(2.0e-6, 0.0, 0.0), Vector3d::Zero(), {}};
  Sheet sheet = make(config);
  run(sheet, 1200);
  EXPECT_FALSE(sheet.at_rest()) << "it goes 0.12 mm in a minute";
}

}  // namespace
}  // namespace kerf::sheet
