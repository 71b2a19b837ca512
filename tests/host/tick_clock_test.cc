#include "server/service/host/tick_clock.h"

#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/manual_clock.h"

namespace kerf::host {
namespace {

using namespace std::chrono_literals;

class TickClockTest : public testing::Test {
 protected:
  TickClockTest() {
    clock_.move_to(100ms);
    ticks_.set_due([this](std::uint64_t call) { calls_.push_back(call); });
  }
  // Returns whether the last call is accepted.
  bool accept_last() { return ticks_.accept(calls_.back()); }
  void end_tick() { ticks_.tick_done(clock_.now(), 1ms, 1.0, 0ms); }

  test::ManualClock clock_;
  SharedSlip slip_;
  TickClock ticks_{10ms, slip_, clock_};
  std::vector<std::uint64_t> calls_;
};

TEST_F(TickClockTest, CallsAtOnceThenAtEachDeadline) {
  ticks_.start();
  ASSERT_EQ(calls_.size(), 1U);
  EXPECT_TRUE(accept_last());
  end_tick();
  ticks_.set_timer();
  EXPECT_TRUE(ticks_.has_timer());
  clock_.move_to(109ms);
  EXPECT_EQ(calls_.size(), 1U);
  clock_.move_to(110ms);
  ASSERT_EQ(calls_.size(), 2U);
  EXPECT_TRUE(accept_last());
  EXPECT_FALSE(ticks_.has_timer());
}

TEST_F(TickClockTest, WhatIsLateIsDueWithoutATimer) {
  ticks_.start();
  clock_.move_to(125ms);
  end_tick();
  ticks_.set_timer();
  EXPECT_EQ(calls_.size(), 2U);
  EXPECT_EQ(clock_.num_timers(), 0U);
}

TEST_F(TickClockTest, RefusesCallsMadeBeforeItStopped) {
  ticks_.start();
  ticks_.stop();
  EXPECT_FALSE(accept_last());
  ticks_.start();
  EXPECT_TRUE(accept_last());
  EXPECT_FALSE(ticks_.accept(calls_.front()));
}

TEST_F(TickClockTest, PausedOrAsleepItHasNoTimer) {
  for (const bool sleeps : {false, true}) {
    ticks_.start();
    end_tick();
    ticks_.set_timer();
    ASSERT_EQ(clock_.num_timers(), 1U);
    sleeps ? ticks_.sleep() : ticks_.pause();
    EXPECT_EQ(ticks_.is_sleeping(), sleeps);
    EXPECT_EQ(ticks_.is_paused(), !sleeps);
    EXPECT_EQ(clock_.num_timers(), 0U);
    EXPECT_FALSE(ticks_.has_timer());
    sleeps ? ticks_.wake() : ticks_.resume();
    EXPECT_EQ(ticks_.mode(), TickClock::Mode::kRunning);
    EXPECT_EQ(clock_.num_timers(), 0U) << "start() sets it";
  }
}

TEST_F(TickClockTest, PausingASleepingOneForgetsItsRepeat) {
  ticks_.sleep();
  ticks_.set_timer_after(3);
  EXPECT_TRUE(ticks_.has_timer());
  EXPECT_EQ(clock_.next_deadline(), Nanoseconds(130ms));
  ticks_.pause();
  EXPECT_TRUE(ticks_.is_paused());
  EXPECT_FALSE(ticks_.is_sleeping());
  EXPECT_EQ(clock_.num_timers(), 0U);
}

TEST_F(TickClockTest, CountsPeriodsAtTheSpeedThatIsSet) {
  ticks_.set_speed(0.5);
  EXPECT_EQ(ticks_.pace().period(), Nanoseconds(20ms));
  ticks_.set_timer_after(2);
  EXPECT_EQ(clock_.next_deadline(), Nanoseconds(140ms));
}

TEST_F(TickClockTest, ATimerThatFiresWhenItIsGoneStillCallsTheReceiver) {
  auto gone = std::make_unique<TickClock>(10ms, slip_, clock_);
  int calls = 0;
  gone->set_due([&calls](std::uint64_t /*call*/) { ++calls; });
  gone->set_timer_after(1);
  gone.reset();
  clock_.move_to(110ms);
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace kerf::host
