// Ticks at their deadlines: missed and made up for, paused, and at another speed.
#include "server/service/host/host.h"
#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

TEST_F(HostTest, TicksAtAbsoluteDeadlines) {
  create("a", small_sheet());
  EXPECT_EQ(status("a").tick, 1);  // the first is due at once
  run_for(100 * kTick);
  const SheetStatus later = status("a");
  EXPECT_EQ(later.tick, 101);
  EXPECT_EQ(later.run_state, RunState::kRunning);
  EXPECT_EQ(later.stats.overruns, 0);
  EXPECT_EQ(later.stats.slipped_s, 0.0);
  EXPECT_NEAR(later.stats.real_time_factor, 1.0, 0.03);
  EXPECT_EQ(host_->metrics().ticks, 101);
  EXPECT_EQ(clock_.next_deadline(), 101 * kTick);
}

TEST_F(HostTest, CatchesUpTwoTicksThenSlipsAndSaysSo) {
  create("a", small_sheet());
  run_for(10 * kTick);
  ASSERT_EQ(status("a").tick, 11);
  // Tick 12 was due at 11 periods; the machine comes back at 15.5: ticks 13 to 16 are due as well. Two are made up for,
  // two given up.
  stall_for(5 * kTick + kTick / 2);
  const SheetStatus late = status("a");
  EXPECT_EQ(late.tick, 14);
  EXPECT_EQ(late.stats.overruns, 2);  // the third made its deadline again
  EXPECT_NEAR(late.stats.slipped_s, 2 * 0.02, 1e-12);
  EXPECT_EQ(clock_.next_deadline(), 16 * kTick);
  run_for(10 * kTick);
  EXPECT_EQ(status("a").tick, 24);
  EXPECT_NEAR(host_->metrics().slipped_s, 0.04, 1e-12);
  EXPECT_EQ(host_->metrics().overruns, 2);
}

TEST_F(HostTest, AShortDelayIsMadeUpForWithoutSlipping) {
  create("a", small_sheet());
  stall_for(2 * kTick + kTick / 4);  // due at 1 and 2 periods
  EXPECT_EQ(status("a").tick, 3);
  EXPECT_EQ(status("a").stats.slipped_s, 0.0);
  run_for(10 * kTick);
  EXPECT_EQ(status("a").tick, 13);
}

TEST_F(HostTest, PausedTimeStandsStillAndResumesWithoutCatchingUp) {
  create("a", small_sheet());
  run_for(5 * kTick);
  Answers<SheetStatus> paused;
  host_->pause("a", paused.callback());
  host_->wait_idle();
  EXPECT_EQ(paused.at(0)->run_state, RunState::kPaused);
  EXPECT_EQ(paused.at(0)->stats.real_time_factor, 0.0);
  EXPECT_EQ(clock_.num_timers(), 0U);
  const std::int32_t settings = paused.at(0)->stats.settings_version;
  stall_for(100 * kTick);
  EXPECT_EQ(status("a").tick, 6);
  Answers<SheetStatus> resumed;
  host_->resume("a", resumed.callback());
  run_for(3 * kTick);
  EXPECT_EQ(status("a").tick, 10);
  EXPECT_EQ(status("a").stats.slipped_s, 0.0);
  EXPECT_GT(status("a").stats.settings_version, settings);
}

TEST_F(HostTest, AtAnotherSpeedTheSameTicksComeAtAnotherPace) {
  create("live", small_sheet());
  create("slow", small_sheet());
  const auto set_speed = [this](double speed) {
    Answers<SheetStatus> answers;
    host_->set_speed("slow", speed, answers.callback());
    host_->wait_idle();
    return answers.at(0);
  };
  EXPECT_EQ(set_speed(0.25).value().stats.speed, 0.25);
  const std::int64_t begun = status("slow").tick;
  run_for(40 * kTick);
  EXPECT_EQ(status("slow").tick, begun + 10);
  EXPECT_EQ(status("slow").stats.overruns, 0);
  EXPECT_EQ(status("slow").stats.slipped_s, 0.0);
  run_for(80 * kTick);
  EXPECT_NEAR(status("slow").stats.real_time_factor, 0.25, 0.01);
  ASSERT_TRUE(set_speed(4.0).ok());
  while (status("slow").tick < status("live").tick) run_for(kTick / 4);
  EXPECT_EQ(status("slow").tick, status("live").tick);
  EXPECT_EQ(status("slow").state_hash, status("live").state_hash);
  EXPECT_EQ(status("slow").stats.overruns, 0);
  EXPECT_EQ(set_speed(4.001).error().field, "speed");
  EXPECT_EQ(set_speed(0.009).error().field, "speed");
  EXPECT_EQ(status("slow").stats.speed, 4.0);
}

TEST_F(HostTest, ASlowTickToComeIsNotWaitedForOnceItIsFast) {
  create("a", small_sheet());
  run_for(kTick / 2);
  const std::int64_t begun = status("a").tick;
  Answers<SheetStatus> answers;
  host_->set_speed("a", 0.01, answers.callback());
  run_for(5 * kTick);
  EXPECT_EQ(status("a").tick, begun) << "the next is due after 100 ticks' time";
  host_->set_speed("a", 1.0, answers.callback());
  run_for(kTick / 2);
  EXPECT_EQ(status("a").tick, begun + 1);
}

TEST_F(HostTest, APausedSheetKeepsItsSpeedForLaterAndAResetLeavesIt) {
  create("a", small_sheet(), true);
  Answers<SheetStatus> answers;
  host_->set_speed("a", 0.5, answers.callback());
  run_for(10 * kTick);
  EXPECT_EQ(status("a").tick, 0);
  ASSERT_TRUE(submit("a", scene::Reset{}).ok());
  host_->resume("a", answers.callback());
  run_for(10 * kTick);
  EXPECT_EQ(status("a").tick, 6) << "one at once, then every other tick's time";
}

}  // namespace
}  // namespace kerf::host
