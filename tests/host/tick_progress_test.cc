#include "server/service/host/tick_progress.h"

#include <gtest/gtest.h>

#include "server/service/host/tick_scale.h"
#include "tests/support/manual_clock.h"

namespace kerf::host {
namespace {

using namespace std::chrono_literals;

TEST(TickProgress, ATickBecomesLongWithTime) {
  test::ManualClock clock;
  TickProgress progress(clock, 100ms);
  EXPECT_FALSE(progress.is_long()) << "none is in progress";
  progress.begin();
  clock.move_to(100ms);
  EXPECT_FALSE(progress.is_long());
  clock.move_to(101ms);
  EXPECT_TRUE(progress.is_long());
  EXPECT_TRUE(progress.is_expected_long());
  progress.end();
  EXPECT_FALSE(progress.is_long());
  EXPECT_TRUE(progress.was_long());
  EXPECT_FALSE(progress.is_expected_long());
}

TEST(TickProgress, AfterALongTickTheNextIsExpectedToBeLong) {
  test::ManualClock clock;
  TickProgress progress(clock, 100ms);
  progress.begin();
  clock.move_to(1s);
  progress.end();
  progress.begin();
  EXPECT_TRUE(progress.is_expected_long());
  EXPECT_FALSE(progress.is_long());
  progress.end();
  EXPECT_FALSE(progress.was_long());
  progress.begin();
  EXPECT_FALSE(progress.is_expected_long());
}

TEST(TickScale, IsTheMeanOfTheFirstTicksThenFollowsTheNewest) {
  TickScale scale;
  EXPECT_EQ(scale.value(), 1.0);
  scale.tick_done(300ns, 100.0);
  EXPECT_NEAR(scale.value(), 3.0, 1e-12);
  scale.tick_done(100ns, 100.0);
  EXPECT_NEAR(scale.value(), 2.0, 1e-12);
  for (int i = 0; i < 100; ++i) scale.tick_done(100ns, 100.0);
  EXPECT_NEAR(scale.value(), 1.0, 1e-3);
  scale.tick_done(200ns, 100.0);
  EXPECT_NEAR(scale.value(), 1.1, 1e-3);
}

TEST(TickScale, LeavesOutTicksWithoutCostOrTime) {
  TickScale scale;
  scale.tick_done(300ns, 0.0);
  scale.tick_done(0ns, 100.0);
  EXPECT_EQ(scale.value(), 1.0);
}

}  // namespace
}  // namespace kerf::host
