#include "server/service/host/pace.h"

#include <vector>

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

using namespace std::chrono_literals;

// Three sheets of one period, each after the other in its turn on a machine that lets them compute a tenth of the time.
TEST(Pace, WhatOneLosesToTheMachineAllLose) {
  SharedSlip shared;
  std::vector<Pace> paces(3, Pace(10ms, shared));
  const std::vector<Nanoseconds> cpu{50us, 400us, 2ms};
  Nanoseconds now = 0ns;
  std::vector<int> ticks(paces.size());
  while (now < 60s) {
    bool any = false;
    for (std::size_t i = 0; i < paces.size(); ++i) {
      if (paces[i].deadline() > now) continue;
      any = true;
      now += 10 * cpu[i];
      paces[i].tick_done(now, cpu[i], 1.0);
      ++ticks[i];
    }
    if (!any) now += 1ms;
  }
  EXPECT_LT(ticks[0], 4000) << "the machine is too slow for them";
  EXPECT_NEAR(ticks[1], ticks[0], 0.02 * ticks[0]);
  EXPECT_NEAR(ticks[2], ticks[0], 0.02 * ticks[0]);
  EXPECT_NEAR(seconds(paces[1].slipped()), seconds(paces[0].slipped()), 0.5);
}

TEST(Pace, WhatATickTakesByItselfIsNoLossOfOthers) {
  SharedSlip shared;
  Pace heavy(10ms, shared);
  for (Nanoseconds now = 0ns; now < 10s; now += 30ms) heavy.tick_done(now + 30ms, 30ms, 1.0);
  EXPECT_GT(seconds(heavy.slipped()), 6.0);
  EXPECT_EQ(shared.total(), 0ns);
  Pace starved(10ms, shared);
  for (Nanoseconds now = 0ns; now < 10s; now += 30ms) starved.tick_done(now + 30ms, 8ms, 1.0);
  EXPECT_EQ(shared.total(), 0ns) << "one that nearly fills its time is late by itself";
}

TEST(Pace, KeepsAbsoluteDeadlines) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(100ms);
  EXPECT_EQ(pace.deadline(), Nanoseconds(100ms));
  pace.tick_done(107ms, 1ms, 1.0);
  EXPECT_EQ(pace.deadline(), Nanoseconds(110ms));
  pace.tick_done(120ms, 1ms, 1.0);  // to the nanosecond: not late, and the next is due
  EXPECT_EQ(pace.overruns(), 0);
  EXPECT_EQ(pace.deadline(), Nanoseconds(120ms));
  pace.tick_done(131ms, 1ms, 1.0);
  EXPECT_EQ(pace.overruns(), 1);
  EXPECT_EQ(pace.deadline(), Nanoseconds(130ms));
  EXPECT_EQ(pace.slipped(), Nanoseconds(0));
  EXPECT_NEAR(pace.tick_cpu_us(), 1000.0, 1e-9);
}

TEST(Pace, GivesUpWhatIsMoreThanTwoTicksLate) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(0ms);
  pace.tick_done(39ms, 1ms, 1.0);  // due: 10, 20, 30
  EXPECT_EQ(pace.slipped(), Nanoseconds(10ms));
  EXPECT_EQ(pace.deadline(), Nanoseconds(20ms));
  SharedSlip of_slow;
  Pace slow(10ms, of_slow);
  slow.start(0ms);
  for (int i = 1; i <= 200; ++i) slow.tick_done(i * 20ms, 20ms, 1.0);  // half as fast as it should be
  EXPECT_NEAR(slow.real_time_factor(), 0.5, 1e-6);
  EXPECT_EQ(slow.slipped() + 200 * 10ms, 4000ms - 10ms);  // one tick behind, all else given up
}

TEST(Pace, CountsWhatAStepStoppedShortOf) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(0ms);
  for (int i = 1; i <= 100; ++i) pace.tick_done(i * 10ms, 1ms, 0.25);
  EXPECT_EQ(pace.overruns(), 0);
  EXPECT_EQ(pace.slipped(), Nanoseconds(750ms));
  EXPECT_NEAR(pace.real_time_factor(), 0.25, 1e-9);
}

TEST(Pace, AtAnotherSpeedTicksAreAsFarApartAsItSays) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(100ms);
  pace.tick_done(101ms, 1ms, 1.0);
  ASSERT_EQ(pace.deadline(), Nanoseconds(110ms));
  pace.set_speed(0.25, 102ms);
  EXPECT_EQ(pace.deadline(), Nanoseconds(140ms));  // 40 ms after the one before it
  pace.tick_done(141ms, 1ms, 1.0);
  EXPECT_EQ(pace.deadline(), Nanoseconds(180ms));
  pace.set_speed(4.0, 150ms);  // it would have been due at 142.5 ms
  EXPECT_EQ(pace.deadline(), Nanoseconds(150ms));
  pace.tick_done(151ms, 1ms, 1.0);
  EXPECT_EQ(pace.deadline(), Nanoseconds(152500us));
  EXPECT_EQ(pace.overruns(), 0);
  EXPECT_EQ(pace.slipped(), Nanoseconds(0));
}

TEST(Pace, AFasterOneForgivesNoDelay) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(0ms);
  pace.tick_done(25ms, 1ms, 1.0);  // the next is due since 10 ms
  pace.set_speed(2.0, 25ms);
  EXPECT_EQ(pace.deadline(), Nanoseconds(10ms));
}

TEST(Pace, TellsWhatIsSimulatedHoweverSlow) {
  SharedSlip of_pace;
  Pace pace(10ms, of_pace);
  pace.start(0ms);
  pace.set_speed(0.5, 0ms);
  for (int i = 1; i <= 100; ++i) pace.tick_done(i * 20ms, 1ms, 1.0);
  EXPECT_NEAR(pace.real_time_factor(), 0.5, 1e-9);
  EXPECT_EQ(pace.overruns(), 0);
  pace.tick_done(2100ms, 1ms, 1.0);  // due: 2030, 2050, 2070, 2090; two of 10 ms simulated are given up
  EXPECT_EQ(pace.overruns(), 1);
  EXPECT_EQ(pace.slipped(), Nanoseconds(20ms));
}

}  // namespace
}  // namespace kerf::host
