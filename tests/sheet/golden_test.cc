#include <cinttypes>
#include <cstdio>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "server/core/sheet/recording.h"
#include "tests/sheet/calls.h"
#include "tests/support/scenes.h"

// State hashes that must come out of every build of the same sources: any optimisation level, any number of threads
// around it, on any x86-64 machine. A change of the numbers in mesh, cut, fem or contact changes them: then look at
// what moved, and put the printed values here.
namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Golden {
  std::string scene;
  std::function<scene::SheetConfig()> config;
  int ticks;
  std::uint64_t hash;
};

scene::SheetConfig stiff_implicit() {
  scene::SheetConfig config = scenes::hanging_with_three_cuts(14);
  config.material = fem::find_preset("wool").value();
  config.integrator.kind = scene::IntegratorKind::kTrBdf2;
  config.integrator.solver = scene::LinearSolverKind::kFactorCg;
  return config;
}

scene::SheetConfig pulled_in_the_wind() {
  scene::SheetConfig config = scenes::hanging(16);
  std::get<scene::GridSource>(config.mesh).pattern = scene::GridPattern::kJitteredDelaunay;
  std::get<scene::GridSource>(config.mesh).seed = 7;
  config.pins = {scene::RegionEdge::kTopCorners};
  config.wind = {Vector3d(2.0, 5.0, 0.0), 1.2, 1.0};
  config.commands = {{1, scene::Grab{"hand", Vector2d(0.52, 0.33), std::nullopt, 0.0}},
                     {5, scene::Drag{"hand", Vector3d(0.5, 0.4, 0.5)}},
                     {10, scenes::line_cut({0.45, 0.5}, {0.6, 0.1})},
                     {20, scene::Release{"hand"}}};
  return config;
}

scene::SheetConfig cut_over_sphere() {
  scene::SheetConfig config = scenes::draped_over_sphere(20);
  config.commands = {{40, scenes::line_cut({-0.1, 0.5}, {0.7, 0.55})}};
  return config;
}

scene::SheetConfig implicit_over_sphere() {
  scene::SheetConfig config = scenes::draped_over_sphere(10);
  config.integrator.kind = scene::IntegratorKind::kImplicitEuler;
  return config;
}

// Fibres, an edge and a box at angles, and a strip with round ends. Double precision rounds no bit of them off.
scene::SheetConfig turned() {
  scene::SheetConfig config = scenes::hanging(14);
  config.material = fem::find_preset("cotton").value();
  config.material.direction = 0.259;
  config.integrator.kind = scene::IntegratorKind::kExplicitLeapfrog;
  config.integrator.precision = scene::Precision::kDouble;
  config.pins.clear();
  scene::Constraint turning;
  turning.region = scene::RegionEdge::kTop;
  turning.rotation = scene::Rotation{{0.3, 0.1, 1.0}, {0.5, 0.0, 1.0}, 0.7};
  turning.history = {{0.0, 1.0}, {0.0, 1.0}};
  config.constraints = {turning};
  config.colliders = {{contact::OrientedBox{{0.5, 0.1, 0.3}, {0.3, 0.1, 0.1}, {1.0, 0.2, 0.0}, 0.9}, 0.4}};
  scene::Cut strip;
  strip.curve = cut::Polyline{{{0.2, 0.3}, {0.5, 0.6}, {0.8, 0.35}}};
  strip.options.width_m = 0.04;
  config.commands = {{5, strip}};
  return config;
}

const Golden kGolden[] = {
    {"hanging 50x50, three cuts", [] { return scenes::hanging_with_three_cuts(50); }, 45, 0xb75aeababfaca2f9},
    {"stiff, implicit, three cuts", stiff_implicit, 40, 0x809e9df9b9096229},
    {"pulled in the wind", pulled_in_the_wind, 40, 0x6591a78c8f6c2751},
    {"cut over a sphere", cut_over_sphere, 60, 0x633025e990500a73},
    {"implicit over a sphere", implicit_over_sphere, 40, 0x9a7011054ce6c168},
    {"turned, in double precision", turned, 40, 0xbf2bb4afd69b587c},
};

TEST(Golden, HashesAreThoseWrittenDown) {
  for (const Golden& golden : kGolden) {
    Sheet sheet = make(golden.config());
    for (int i = 0; i < golden.ticks; ++i) {
      const TickReport report = sheet.step({});
      for (const ScheduledReply& scheduled : report.scheduled) EXPECT_TRUE(scheduled.reply.ok()) << golden.scene;
      EXPECT_FALSE(report.step_failed) << golden.scene;
    }
    std::printf("%s, %d ticks: 0x%016" PRIx64 "\n", golden.scene.c_str(), golden.ticks, sheet.state_hash());
    EXPECT_EQ(sheet.state_hash(), golden.hash) << golden.scene;
  }
}

TEST(Golden, TwoRunsAgreeAtEveryTick) {
  for (const auto& config : {pulled_in_the_wind(), cut_over_sphere()}) {
    Sheet first = make(config);
    Sheet second = make(config);
    for (int i = 0; i < 50; ++i) {
      first.step({});
      second.step({});
      ASSERT_EQ(first.state_hash(), second.state_hash()) << "tick " << first.tick();
    }
  }
}

TEST(Golden, ACopyContinuesWithEqualHashes) {
  for (const Golden& golden : kGolden) {
    Sheet original = make(golden.config());
    for (int i = 0; i < 15; ++i) original.step({});
    Sheet copy = original;
    ASSERT_EQ(copy.state_hash(), original.state_hash());
    const std::vector<scene::Command> cut{scenes::bezier_cut({0.1, 0.6}, {0.3, 0.4}, {0.5, 0.7}, {0.7, 0.6})};
    original.step(cut);
    copy.step(cut);
    for (int i = 0; i < 15; ++i) {
      original.step({});
      copy.step({});
      ASSERT_EQ(copy.state_hash(), original.state_hash()) << golden.scene << " tick " << copy.tick();
    }
  }
}

// A run with commands of every kind, some while time stands still.
Recording record() {
  Recorder recorder;
  scene::SheetConfig config = pulled_in_the_wind();
  recorder.start(config);
  Sheet sheet = make(config);
  const auto note = [&](std::vector<scene::Command> commands, bool advance) {
    const TickReport report = advance ? sheet.step(commands) : sheet.apply(commands);
    recorder.append({report.tick, std::move(commands), sheet.state_hash()});
  };
  note({scenes::circle_cut({0.3, 0.6}, 0.1)}, false);
  for (int i = 0; i < 12; ++i) note({}, true);
  note({scene::SetGravity{Vector3d(0, 0, -3)}, scene::Drag{"nobody", Vector3d(0, 0, 0)}}, true);
  note({scene::SetPins{{scene::RegionEdge::kLeft}}, scenes::line_cut({0.2, -0.1}, {0.25, 1.1})}, false);
  for (int i = 0; i < 12; ++i) note({}, true);
  note({scene::SetWind{{Vector3d(0, -3, 0), 1.2, 1.0}}, scene::Grab{"second", 20, std::nullopt, 30.0}}, true);
  for (int i = 0; i < 5; ++i) note({}, true);
  note({scene::Reset{}}, true);
  for (int i = 0; i < 5; ++i) note({}, true);
  return recorder.recording();
}

TEST(Recording, ReplaysBitForBit) {
  const Recording recording = record();
  const Result<ReplayReport> report = replay(recording);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_FALSE(report->divergence.has_value()) << "tick " << report->divergence->tick;
  EXPECT_EQ(report->ticks, 37);
}

TEST(Recording, NamesTheFirstTickThatDiffers) {
  Recording recording = record();
  recording.entries[9].state_hash ^= 1U;
  recording.entries[20].state_hash ^= 1U;
  const Result<ReplayReport> report = replay(recording);
  ASSERT_TRUE(report.ok());
  ASSERT_TRUE(report->divergence.has_value());
  EXPECT_EQ(report->divergence->entry, 9U);
  EXPECT_EQ(report->divergence->tick, 9);
  EXPECT_EQ(report->divergence->recorded_hash, recording.entries[9].state_hash);
  EXPECT_EQ(report->divergence->replayed_hash, recording.entries[9].state_hash ^ 1U);
}

TEST(Recording, ACommandLeftOutDiverges) {
  Recording recording = record();
  recording.entries[13].commands.erase(recording.entries[13].commands.begin());
  const Result<ReplayReport> report = replay(recording);
  ASSERT_TRUE(report.ok());
  ASSERT_TRUE(report->divergence.has_value());
  EXPECT_EQ(report->divergence->tick, 13);
}

TEST(Recording, TicksLeftOutAreSteppedAllTheSame) {
  const Recording whole = record();
  Recording recording = whole;
  std::erase_if(recording.entries, [&](const RecordedTick& entry) {
    return entry.commands.empty() && entry.tick != whole.entries.back().tick;
  });
  ASSERT_LT(recording.entries.size(), whole.entries.size());
  const Result<ReplayReport> report = replay(recording);
  ASSERT_TRUE(report.ok());
  EXPECT_FALSE(report->divergence.has_value());
  EXPECT_EQ(report->ticks, whole.entries.back().tick);
}

TEST(Recording, RefusesGapsBeyondTheLimit) {
  Recording recording = record();
  const std::int64_t last = recording.entries.back().tick;
  recording.entries.push_back({last + kMaxRecordedGap, {}, 0});
  EXPECT_TRUE(check_order(recording.entries).ok());
  ++recording.entries.back().tick;
  EXPECT_EQ(check_order(recording.entries).error().reason, "RECORDING_ORDER");
}

TEST(Recording, RefusesEntriesThatTellNothingAndTicksWithTooManyCommands) {
  Recording recording = record();
  const std::int64_t last = recording.entries.back().tick;
  recording.entries.push_back({last, {}, 0});
  EXPECT_EQ(check_order(recording.entries).error().reason, "RECORDING_ORDER");
  recording.entries.back().commands.assign(kMaxTickCommands, scene::UndoCut{});
  EXPECT_TRUE(check_order(recording.entries).ok());
  recording.entries.back().commands.emplace_back(scene::UndoCut{});
  EXPECT_EQ(check_order(recording.entries).error().reason, "RECORDING_TICK");
}

TEST(Recording, RefusesTicksOutOfOrder) {
  Recording recording = record();
  recording.entries[5].tick = 40;
  const Result<ReplayReport> report = replay(recording);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().reason, "RECORDING_ORDER");
}

}  // namespace
}  // namespace kerf::sheet
