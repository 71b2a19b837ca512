// Scenes that play again by themselves: SheetConfig::repeat_after.
#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

// Its own cut comes at tick 10, it falls asleep some 100 ticks later, and plays again after 150.
scene::SheetConfig story() {
  scene::SheetConfig config = scenes::flat(5);
  config.gravity = Eigen::Vector3d::Zero();
  config.tick_rate_hz = 50.0;
  config.commands = {{10, scenes::line_cut({-0.1, 0.4}, {1.1, 0.6})}};
  config.repeat_after = 150;
  return config;
}

class HostRepeatTest : public HostTest {
 protected:
  std::shared_ptr<RecordingSnapshots> watch() {
    auto sink = std::make_shared<RecordingSnapshots>();
    Answers<Nothing> added;
    host_->add_sink("a", sink, added.callback());
    host_->wait_idle();
    return sink;
  }
};

TEST_F(HostRepeatTest, AStoryPlaysAgainWhileSomebodyWatches) {
  create("a", story());
  const auto sink = watch();
  run_for(15 * kTick);
  EXPECT_EQ(status("a").pieces, 2);
  run_for(137 * kTick);
  EXPECT_EQ(status("a").pieces, 1) << "begun again";
  EXPECT_LT(status("a").scene_tick, 10);
  run_for(15 * kTick);
  EXPECT_EQ(status("a").pieces, 2);
  EXPECT_EQ(status("a").stats.resets, 0) << "no client asked for that";
  EXPECT_EQ(submit("a", scene::UndoCut{})->reply.undone->cuts.size(), 1U);
}

TEST_F(HostRepeatTest, AStoryThatNobodyWatchesSleepsUntilSomebodyComes) {
  create("a", story());
  run_for(400 * kTick);
  ASSERT_EQ(status("a").run_state, RunState::kSleeping);
  EXPECT_EQ(status("a").pieces, 2);
  const std::int64_t tick = status("a").tick;
  EXPECT_LT(tick, 150);
  const auto sink = watch();
  run_for(3 * kTick);
  EXPECT_EQ(status("a").run_state, RunState::kRunning);
  EXPECT_EQ(status("a").pieces, 1) << "the visitor sees it from its beginning";
  sink->want(false);
  run_for(400 * kTick);
  ASSERT_EQ(status("a").run_state, RunState::kSleeping) << "nobody looks";
  EXPECT_LT(status("a").tick, tick + 200);
}

TEST_F(HostRepeatTest, WhatAClientChangedIsNotTakenAway) {
  create("a", story());
  const auto sink = watch();
  run_for(20 * kTick);
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.8}, {1.1, 0.7})).ok());
  run_for(600 * kTick);
  EXPECT_EQ(status("a").pieces, 3);
  EXPECT_EQ(status("a").run_state, RunState::kSleeping);
  EXPECT_EQ(clock_.num_timers(), 0U) << "asleep it costs nothing";
  // After a reset it is the scene's own story again.
  ASSERT_TRUE(submit("a", scene::Reset{}).ok());
  EXPECT_EQ(status("a").stats.resets, 1);
  run_for(165 * kTick);
  EXPECT_EQ(status("a").pieces, 2);
  EXPECT_LT(status("a").scene_tick, 30);
}

TEST_F(HostRepeatTest, ARefusedCommandIsNoChange) {
  create("a", story());
  const auto sink = watch();
  run_for(20 * kTick);
  EXPECT_FALSE(submit("a", scene::Release{"nobody"}).ok());
  run_for(140 * kTick);
  EXPECT_LT(status("a").scene_tick, 20);
}

TEST_F(HostRepeatTest, APausedStoryWaits) {
  create("a", story());
  const auto sink = watch();
  Answers<SheetStatus> paused;
  host_->pause("a", paused.callback());
  run_for(600 * kTick);
  const std::int64_t tick = status("a").tick;
  EXPECT_LT(tick, 5);
  EXPECT_EQ(status("a").viewers, 1);
}

TEST_F(HostRepeatTest, ResetsAndTheirUndosAreCounted) {
  create("a", story());
  ASSERT_TRUE(submit("a", scene::Reset{}).ok());
  ASSERT_TRUE(submit("a", scene::UndoCut{}).ok());
  ASSERT_TRUE(submit("a", scene::RedoCut{}).ok());
  EXPECT_EQ(status("a").stats.resets, 2);
  EXPECT_EQ(status("a").stats.resets_undone, 1);
}

}  // namespace
}  // namespace kerf::host
