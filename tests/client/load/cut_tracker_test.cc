#include "client/load/cut_tracker.h"

#include <chrono>

#include <gtest/gtest.h>

namespace kerf::load {
namespace {

using namespace std::chrono_literals;

class CutTrackerTest : public testing::Test {
 protected:
  CutTrackerTest() {
    recorder_.measure(0s, 100s);
    tracker_.watch(3);
  }
  CutTotals totals() const { return recorder_.cut_totals(); }

  Recorder recorder_;
  CutTracker tracker_{recorder_};
};

TEST_F(CutTrackerTest, TheFirstFrameOfTheTickCounts) {
  EXPECT_FALSE(tracker_.newest_tick(3));
  tracker_.frame(3, 9, 1, 90ms);
  EXPECT_EQ(tracker_.newest_tick(3), 9);
  tracker_.applied(3, 11, 2, 100ms);
  tracker_.frame(3, 10, 1, 120ms);
  EXPECT_EQ(totals().seen_us.count(), 0);
  tracker_.frame(3, 11, 2, 130ms);
  tracker_.frame(3, 12, 2, 140ms);
  EXPECT_EQ(totals().seen_us.count(), 1);
  EXPECT_EQ(totals().seen_us.max(), 30'000);
  EXPECT_EQ(totals().seen_without, 0);
}

TEST_F(CutTrackerTest, TheReplyMayComeAfterTheFrame) {
  tracker_.frame(3, 11, 2, 130ms);
  tracker_.frame(3, 12, 2, 140ms);
  tracker_.applied(3, 11, 2, 100ms);
  EXPECT_EQ(totals().seen_us.max(), 30'000);
}

TEST_F(CutTrackerTest, AFrameWithoutItIsAnError) {
  tracker_.applied(3, 11, 5, 100ms);
  tracker_.frame(3, 13, 4, 130ms);
  EXPECT_EQ(totals().seen_us.count(), 1);
  EXPECT_EQ(totals().seen_without, 1);
}

TEST_F(CutTrackerTest, CutsOfASheetThatNobodyWatchesAnyMoreAreLeftOut) {
  tracker_.applied(3, 11, 2, 100ms);
  EXPECT_EQ(tracker_.num_waiting(), 1);
  tracker_.unwatch(3);
  tracker_.frame(3, 12, 2, 130ms);  // From a viewer that closes just now.
  tracker_.applied(3, 13, 3, 140ms);
  EXPECT_EQ(tracker_.num_waiting(), 0);
  EXPECT_FALSE(tracker_.newest_tick(3));
  tracker_.finish();
  EXPECT_EQ(totals().seen_us.count() + totals().unseen, 0);
}

TEST_F(CutTrackerTest, WhatIsNeverShownIsCountedAtTheEnd) {
  tracker_.applied(3, 11, 2, 100ms);
  tracker_.applied(4, 11, 2, 100ms);  // That one is not watched.
  tracker_.frame(3, 10, 1, 110ms);
  EXPECT_EQ(tracker_.num_waiting(), 1);
  tracker_.finish();
  EXPECT_EQ(tracker_.num_waiting(), 0);
  EXPECT_EQ(totals().unseen, 1);
  EXPECT_EQ(totals().seen_us.count(), 0);
  EXPECT_FALSE(tracker_.newest_tick(4));
}

}  // namespace
}  // namespace kerf::load
