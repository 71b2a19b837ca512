// Reset, and what takes it back.
#include <algorithm>
#include <vector>

#include "server/core/fem/model/tick_cost.h"
#include "server/core/sheet/undo_history.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector3d;
using scenes::line_cut;

scene::Cut across(double y) {
  return line_cut({-0.1, y}, {1.1, y + 0.02});
}

// Something of everything that a scene does over time.
scene::SheetConfig eventful() {
  scene::SheetConfig config = scenes::hanging(8);
  config.commands = {
      {1, scene::SetWind{{Vector3d(0.0, 2.0, 0.0), 1.2, 1.0}}}, {6, across(0.31)}, {9, scene::SetGravity{{0, 0, -5}}}};
  config.gravity_history = {{0.0, 0.1, 0.2}, {1.0, 0.5, 1.0}};
  return config;
}

TEST(Reset, BringsTheSceneBackWholeWithItsClockScheduleAndHistories) {
  Sheet sheet = make(eventful());
  run(sheet, 14);
  ASSERT_TRUE(apply(sheet, across(0.6)).ok());
  run(sheet, 3);
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_EQ(sheet.tick(), 17) << "the tick counts on";
  EXPECT_EQ(sheet.scene_tick(), 0);
  Sheet fresh = make(eventful());
  EXPECT_EQ(sheet.shape_hash(), fresh.shape_hash());
  for (int tick = 1; tick <= 20; ++tick) {
    run(sheet, 1);
    run(fresh, 1);
    ASSERT_EQ(sheet.shape_hash(), fresh.shape_hash()) << "tick " << tick;
  }
  EXPECT_EQ(sheet.scene_tick(), 20);
}

TEST(Reset, InARunningTickBeginsWithTheFirstTickOfTheScene) {
  Sheet sheet = make(eventful());
  run(sheet, 14);
  const std::vector<scene::Command> commands{scene::Reset{}};
  const TickReport report = sheet.step(commands);
  EXPECT_EQ(report.scheduled.size(), 1U);
  EXPECT_EQ(report.num_scheduled_first, 0U);
  Sheet fresh = make(eventful());
  for (int tick = 1; tick <= 12; ++tick) {
    run(fresh, 1);
    ASSERT_EQ(sheet.shape_hash(), fresh.shape_hash()) << "tick " << tick;
    run(sheet, 1);
  }
}

// The last step's integrator says nothing about the present sheet.
TEST(Reset, ChoosesTheIntegratorOfAFreshSheetAfterAStepInDouble) {
  scene::SheetConfig config = scenes::hanging(24);
  Sheet sheet = make(config);
  ASSERT_TRUE(apply(sheet, across(0.5)).ok());
  run(sheet, 60);
  const std::vector<scene::Command> undo{scene::UndoCut{}};
  ASSERT_TRUE(sheet.step(undo).stats.is_double) << "the half that fell is put back, far away";
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  Sheet fresh = make(config);
  EXPECT_EQ(sheet.integrator_description(), fresh.integrator_description());
  EXPECT_EQ(sheet.expected_cost().total(), fresh.expected_cost().total());
}

TEST(Reset, OfTheSceneItselfDoesNotRepeatItsSchedule) {
  scene::SheetConfig config = scenes::hanging(6);
  config.commands = {{1, scene::Reset{}}, {2, across(0.45)}, {5, scene::Reset{}}};
  Sheet sheet = make(config);
  run(sheet, 4);
  EXPECT_EQ(sheet.mesh().num_pieces(), 2);
  run(sheet, 20);
  EXPECT_EQ(sheet.mesh().num_pieces(), 1);
  EXPECT_EQ(sheet.num_cuts(), 1);
}

TEST(Reset, IsTakenBackBitForBit) {
  Sheet sheet = make(eventful());
  run(sheet, 12);
  ASSERT_TRUE(apply(sheet, across(0.7)).ok());
  ASSERT_TRUE(apply(sheet, scene::SetPins{{scene::RegionEdge::kTopCorners}}).ok());
  run(sheet, 2);
  Sheet untouched = sheet;
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  run(sheet, 9);
  ASSERT_EQ(apply(sheet, scene::UndoCut{})->undone->cuts.size(), 1U) << "the cut that the scene made since";
  const Result<scene::CommandReply> undone = apply(sheet, scene::UndoCut{});
  ASSERT_TRUE(undone.ok()) << undone.error().message;
  EXPECT_TRUE(undone->undone->reset);
  EXPECT_TRUE(undone->undone->cuts.empty());
  EXPECT_EQ(undone->undone->pieces, untouched.mesh().num_pieces());
  EXPECT_EQ(sheet.shape_hash(), untouched.shape_hash());
  EXPECT_EQ(sheet.tick(), 23) << "the tick counts on";
  for (int tick = 1; tick <= 10; ++tick) {
    run(sheet, 1);
    run(untouched, 1);
    ASSERT_EQ(sheet.shape_hash(), untouched.shape_hash()) << "tick " << tick;
  }
}

TEST(Reset, IsAStepOfTheHistoryAmongCuts) {
  Sheet sheet = make(scenes::hanging(8));
  const auto pieces = [&sheet] { return sheet.mesh().num_pieces(); };
  ASSERT_TRUE(apply(sheet, across(0.3)).ok());
  const std::uint64_t one_cut = sheet.mesh().state_hash();
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_EQ(reason(apply(sheet, scene::RedoCut{})), "NOTHING_TO_REDO");
  ASSERT_TRUE(apply(sheet, across(0.5)).ok());
  ASSERT_TRUE(apply(sheet, across(0.8)).ok());
  const std::uint64_t two_cuts = sheet.mesh().state_hash();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.mesh().state_hash(), one_cut) << "two cuts and the reset were undone";
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(pieces(), 1);
  EXPECT_EQ(reason(apply(sheet, scene::UndoCut{})), "NOTHING_TO_UNDO");
  ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
  EXPECT_EQ(sheet.mesh().state_hash(), one_cut);
  const Result<scene::CommandReply> again = apply(sheet, scene::RedoCut{});
  ASSERT_TRUE(again.ok());
  EXPECT_TRUE(again->undone->reset);
  EXPECT_EQ(pieces(), 1);
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
  EXPECT_EQ(sheet.mesh().state_hash(), two_cuts);
}

TEST(Reset, ThatIsUndoneLeavesPiecesTheirIdsAndGivesNoneTwice) {
  Sheet sheet = make(scenes::hanging(8));
  ASSERT_TRUE(apply(sheet, across(0.3)).ok());
  const std::vector<std::int64_t> before = piece_ids(sheet);
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  ASSERT_TRUE(apply(sheet, across(0.6)).ok());
  const std::vector<std::int64_t> between = piece_ids(sheet);
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(piece_ids(sheet), before);
  for (const std::int64_t id : between) EXPECT_EQ(std::count(before.begin(), before.end(), id), 0) << id;
}

TEST(Reset, LetsGoAndItsUndoDoesNotTakeHoldAgain) {
  Sheet sheet = make(scenes::hanging(6));
  ASSERT_TRUE(apply(sheet, scene::Grab{"hand", 0, std::nullopt, 0.0}).ok());
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_TRUE(sheet.grabs().empty());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_TRUE(sheet.grabs().empty()) << "whoever held it knows that the grab is gone";
}

TEST(Reset, ThatRepeatsTheSceneKeepsNothing) {
  Sheet sheet = make(scenes::hanging(6));
  ASSERT_TRUE(apply(sheet, across(0.3)).ok());
  ASSERT_TRUE(apply(sheet, scene::Reset{.repeats = true}).ok());
  EXPECT_EQ(reason(apply(sheet, scene::UndoCut{})), "NOTHING_TO_UNDO");
  scene::SheetConfig config = scenes::hanging(6);
  config.commands = {{3, scene::Reset{.repeats = true}}};
  EXPECT_EQ(refused(config), "OUT_OF_RANGE commands[0].command.reset.repeats");
}

TEST(Reset, WhatIsKeptForUndoIsBounded) {
  Sheet sheet = make(scenes::hanging(60));
  ASSERT_TRUE(apply(sheet, across(0.3)).ok());
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_LE(sheet.history().bytes(), UndoHistory::kMaxBytes);
  const std::size_t kept = sheet.history().num_done();
  EXPECT_GT(kept, 20U);
  EXPECT_LT(kept, 101U);
  for (std::size_t i = 0; i < kept; ++i) ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(reason(apply(sheet, scene::UndoCut{})), "UNDO_FORGOTTEN");
}

TEST(Reset, GivesEachBeginningANumberOfItsOwn) {
  Sheet sheet = make(scenes::hanging(6));
  EXPECT_EQ(apply(sheet, across(0.3))->beginning, 0);
  EXPECT_EQ(apply(sheet, scene::Reset{})->beginning, 1);
  EXPECT_EQ(apply(sheet, scene::Reset{})->beginning, 2);
  EXPECT_EQ(apply(sheet, scene::UndoCut{})->beginning, 1);
  EXPECT_EQ(apply(sheet, scene::RedoCut{})->beginning, 2);
  EXPECT_EQ(apply(sheet, scene::UndoCut{})->beginning, 1);
  EXPECT_EQ(apply(sheet, across(0.6))->beginning, 1);
  EXPECT_EQ(apply(sheet, scene::Reset{})->beginning, 3);
}

}  // namespace
}  // namespace kerf::sheet
