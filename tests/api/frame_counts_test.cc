// Counts the encodings for many viewers of one sheet: one per tick, not per viewer.

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/api/fixture.h"
#include "tests/api/viewer.h"

namespace kerf::api {
namespace {

constexpr int kEncodedTicks = 40;

class FrameCountsTest : public ApiTest {
 protected:
  // So many more viewers, each with its first frame.
  void join(int count, double max_rate_hz) {
    for (int i = 0; i < count; ++i) {
      viewers_.push_back(std::make_unique<Viewer>(*api_));
      viewers_.back()->start("sheets/a", 2, max_rate_hz);
    }
    run_for(kTick);
    drain();
  }
  void drain() {
    for (const auto& viewer : viewers_) viewer->drain();
  }
  // Counts the frames encoded and sent in kEncodedTicks ticks.
  FrameCounts watch() {
    const FrameCounts before = api_->frame_counts();
    for (int tick = 0; tick < kEncodedTicks; ++tick) {
      run_for(kTick);
      drain();
    }
    const FrameCounts after = api_->frame_counts();
    return {after.encoded - before.encoded, after.sent - before.sent};
  }

  std::vector<std::unique_ptr<Viewer>> viewers_;
};

TEST_F(FrameCountsTest, ViewersAtOneRateShareOneEncodingATick) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  EXPECT_EQ(api_->frame_counts().encoded, 0);
  join(60, 0.0);
  EXPECT_EQ(api_->frame_counts().encoded, 1) << "a keyframe for all of them";
  EXPECT_EQ(api_->frame_counts().sent, 60);
  const FrameCounts counts = watch();
  EXPECT_EQ(counts.encoded, kEncodedTicks);
  EXPECT_EQ(counts.sent, 60 * kEncodedTicks);
}

TEST_F(FrameCountsTest, AnotherRateCostsOneMoreWhenItIsDue) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  join(30, 0.0);
  join(30, 10.0);  // of 50 ticks a second
  const FrameCounts counts = watch();
  EXPECT_EQ(counts.encoded, kEncodedTicks + kEncodedTicks / 5);
  EXPECT_EQ(counts.sent, 30 * kEncodedTicks + 30 * kEncodedTicks / 5);
}

TEST_F(FrameCountsTest, ASheetThatStandsAndOneThatNobodyWatchesCostNothing) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(create_sheet("b", false).ok());
  join(20, 0.0);
  const FrameCounts counts = watch();
  EXPECT_EQ(counts.encoded, 0);
  EXPECT_EQ(counts.sent, 0);
}

}  // namespace
}  // namespace kerf::api
